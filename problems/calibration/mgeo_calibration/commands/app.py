"""Command line of simulation and calibration: options of ``mgeo attitude verify``, ``fly`` and
``calibrate``.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer
from mgeo_attitude.commands.app import USER_ERRORS, Overwrite, Pick, Solution, Source, Time

from mgeo.cli.errors import ExitCode, convert_input_errors
from mgeo.cli.help_text import format_examples
from mgeo.cli.options import Debug, Json, Quiet
from mgeo.terminal import Output, format_json

if TYPE_CHECKING:
    from mgeo_calibration.documents import SimulationDocument

    pass

app = typer.Typer()

EXAMPLES: Mapping[str, tuple[str, ...]] = {
    "verify": (
        "mgeo attitude verify plan.json --monte-carlo 500",
        "mgeo attitude verify runs/first --pick min-trace --all",
    ),
    "fly": (
        "mgeo attitude fly plan.json --out telemetry.csv --truth truth.json",
        "mgeo attitude fly plan.json --simulator basilisk --vehicle cubesat_6u --seed 2",
        "mgeo attitude fly second.json --after truth.json --out second.csv",
    ),
    "calibrate": (
        "mgeo attitude calibrate telemetry.csv --scenario mine.toml --out calibration",
        "mgeo attitude calibrate telemetry.csv --plan plan.json --mapping columns.toml",
        "mgeo attitude calibrate telemetry.csv --scenario mine.toml --all --fit noise",
    ),
}


@app.command(epilog=format_examples("verify", EXAMPLES))
def verify(
    source: Source,
    pick: Pick = None,
    time: Time = None,
    solution: Solution = None,
    monte_carlo: Annotated[int, typer.Option(min=2, help="Number of Monte Carlo runs.")] = 200,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the random errors.")] = 1,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="Result file [default for a run: verification-solutionN-seedS.json in its "
            "folder, for `mgeo report`].",
        ),
    ] = None,
    show_all: Annotated[bool, typer.Option("--all", help="Print every axis.")] = False,
    overwrite: Overwrite = False,
    quiet: Quiet = False,
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Test in Monte Carlo runs whether a plan achieves its predicted accuracy.

    The runs simulate the nonlinear truth, with errors drawn from the scenario, and the error-state
    filter. The result includes how often path constraints are violated. The exit code is 3 if the
    accuracy is not achieved, or if the plan violates a constraint of its scenario.
    """
    from mgeo_attitude.commands.files import check_targets, load_plan
    from mgeo_attitude.scenario.validity import OutsideValidity

    from mgeo.store.atomic import write_file
    from mgeo_calibration import verification
    from mgeo_calibration.commands import verify as command

    output = Output(quiet, json)
    with convert_input_errors(USER_ERRORS):
        check_targets([out], overwrite)
        picked = load_plan(source, pick, time, solution)
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always", OutsideValidity)
            result = verification.verify(picked.plan, monte_carlo, seed)
        for warning in caught:
            output.print_note(f"Note: {warning.message}")
        document = command.build_verification_document(picked, result, seed)
        if target := out or command.build_result_path(source, picked, seed):
            write_file(target, f"{format_json(document)}\n".encode())
        command.print_verification(picked, result, target, output, has_all_axes=show_all)
        output.print_document(document)
    is_verified = result.is_achieved and not document["violations"]
    raise typer.Exit(ExitCode.SUCCESS if is_verified else ExitCode.INCOMPLETE)


@app.command(epilog=format_examples("fly", EXAMPLES))
def fly(
    source: Source,
    pick: Pick = None,
    time: Time = None,
    solution: Solution = None,
    simulator: Annotated[
        Literal["kinematic", "basilisk"],
        typer.Option(
            metavar="kinematic|basilisk",
            help="kinematic: planned rates executed exactly; basilisk: rigid-body dynamics with "
            "actuators and attitude control.",
        ),
    ] = "kinematic",
    vehicle: Annotated[
        Literal["paper", "cubesat_6u"] | None,
        typer.Option(
            metavar="paper|cubesat_6u",
            help="Satellite with inertia and wheels for Basilisk [default: from the scenario].",
        ),
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the random errors and the noise.")] = 1,
    after: Annotated[
        Path | None,
        typer.Option(
            metavar="TRUTH.json",
            help="Start with the true attitude and errors at the end of an earlier run.",
        ),
    ] = None,
    until: Annotated[
        float | None, typer.Option(metavar="SECONDS", help="End the telemetry at this time.")
    ] = None,
    out: Annotated[
        Path, typer.Option(metavar="FILE.csv", help="Telemetry for `mgeo attitude calibrate`.")
    ] = Path("telemetry.csv"),
    truth: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.json",
            help="Also write the true attitude and errors at the end, for --after.",
        ),
    ] = None,
    overwrite: Overwrite = False,
    quiet: Quiet = False,
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Simulate one run of a plan and write its telemetry.

    The run lasts for the duration of the scenario, or until --until. The initial attitude and the
    errors of gyro and sensors are random, with the 1-sigmas of the scenario; with --after, they are
    those at the end of an earlier run. Both simulators draw the same initial errors for the same
    seed.
    """
    from mgeo_attitude.commands.files import check_targets, load_plan

    from mgeo.plugins.review import build_records
    from mgeo.store.atomic import encode_json, write_file
    from mgeo_calibration.commands import fly as command
    from mgeo_calibration.simulators.plan_comparison import compare_with_plan
    from mgeo_calibration.simulators.truth import build_truth_document, read_truth

    with convert_input_errors(USER_ERRORS):
        check_targets([out], overwrite, (".csv",))
        check_targets([truth], overwrite, (".json",))
        picked = load_plan(source, pick, time, solution)
        plan = picked.plan
        before = read_truth(after, plan) if after else None
        telemetry = command.simulate_plan(plan, simulator, vehicle, seed, before)
        telemetry = telemetry if until is None else telemetry.truncate(until)
        document = build_truth_document(plan, telemetry, simulator, seed)
        compared = compare_with_plan(plan, telemetry)
        telemetry.to_csv(out)
        if truth:
            write_file(truth, encode_json(document))
    files = {str(out): "telemetry"}
    if truth:
        files[str(truth)] = "true attitude and errors at the last sample, for --after"
    selection = {"--plan": source, "--pick": pick, "--time": time, "--solution": solution}
    options = " ".join(f"{flag} {value}" for flag, value in selection.items() if value is not None)
    output = Output(quiet, json)
    command.print_simulation(picked, options, telemetry, compared, simulator, files, output)
    simulation: SimulationDocument = {
        "files": list(files),
        "n_samples": len(telemetry.times),
        "comparison": build_records(compared),
        "truth": document,
    }
    output.print_document(simulation)


@app.command(epilog=format_examples("calibrate", EXAMPLES))
def calibrate(
    telemetry: Annotated[
        Path, typer.Argument(metavar="TELEMETRY", help="Telemetry table in CSV or .parquet.")
    ],
    scenario: Annotated[
        str | None,
        typer.Option(
            metavar="FILE.toml|PRESET",
            help="Satellite, orbit and epoch [default: scenario of --plan].",
        ),
    ] = None,
    plan: Annotated[
        Path | None,
        typer.Option(
            metavar="RUN|PLAN.json", help="Compare with the predicted 1-sigmas of a plan."
        ),
    ] = None,
    pick: Pick = None,
    time: Time = None,
    solution: Solution = None,
    mapping: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.toml",
            help="Columns, units and mounting rotations that differ from the defaults.",
        ),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Folder for JSON, CSV and HTML report."),
    ] = None,
    fit: Annotated[
        str | None,
        typer.Option(
            metavar="KEY,...",
            help="Repeat the calibration with these parameters added, such as mag.scale_factor, "
            "or with sensor noise estimated from telemetry (noise).",
        ),
    ] = None,
    show_all: Annotated[
        bool,
        typer.Option(
            "--all",
            help="Also print every axis and every test, or all checks if telemetry cannot be "
            "calibrated.",
        ),
    ] = False,
    overwrite: Overwrite = False,
    quiet: Quiet = False,
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Estimate the calibration parameters of gyro and sensors from telemetry, and test them.

    No initial attitude is needed. Outliers are rejected and counted. The exit code is 3 if
    telemetry and scenario are statistically inconsistent.
    """
    from mgeo_attitude.scenario.validity import ImplausibleValue

    from mgeo_calibration.calibration.calibrate import calibrate as run_calibration
    from mgeo_calibration.calibration.diagnosis import CalibrationError
    from mgeo_calibration.calibration.magnetometer_calibration import calibrate_magnetometers
    from mgeo_calibration.calibration.recalibration import recalibrate
    from mgeo_calibration.commands import calibrate as command
    from mgeo_calibration.telemetry.mapping import TelemetryMapping
    from mgeo_calibration.telemetry.reading import read_telemetry

    output = Output(quiet, json)
    with convert_input_errors(USER_ERRORS):
        if out:
            command.validate_folder(out, overwrite)
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always", ImplausibleValue)
            picked = command.load_optional_plan(plan, pick, time, solution)
            selected_plan = picked.plan if picked else None
            used_scenario = command.select_scenario(scenario, selected_plan)
        for line in dict.fromkeys(str(warning.message) for warning in caught):
            output.print_note(f"Note: {line}")
        declarations = TelemetryMapping.from_toml(mapping) if mapping else None
        is_without_attitude = declarations and declarations.gyro.reference_axes == "unknown"
        if is_without_attitude and fit is not None:
            raise ValueError(
                '--fit: expected no value with reference_axes = "unknown" in the mapping, because '
                "the calibration has no attitude. Remove --fit"
            )
        samples = read_telemetry(telemetry, used_scenario, declarations)
        try:
            if is_without_attitude:
                result = calibrate_magnetometers(used_scenario, samples)
            else:
                result = run_calibration(used_scenario, samples, declarations)
        except CalibrationError as error:
            if show_all:
                command.print_checks(error, output)
            raise
        predicted = result.compare(selected_plan) if selected_plan else None
        first = result
        if fit is not None:
            result = recalibrate(first, samples, [key.strip() for key in fit.split(",")])
        files = command.write_calibration(result, predicted, out) if out else []
    command.print_calibration(result, first, predicted, files, output, has_details=show_all)
    output.print_document(command.build_calibration_document(result, predicted, files))
    raise typer.Exit(ExitCode.SUCCESS if result.is_consistent else ExitCode.INCOMPLETE)
