"""What comes after a plan, as commands ``mgeo attitude verify | fly | calibrate``."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Literal

import typer
from mgeo_attitude.commands.app import USERS, Overwrite, Pick, Solution, Source, Time

from mgeo.cli.app import epilog
from mgeo.cli.errors import ExitCode, bad_input
from mgeo.cli.options import Debug, Json, Quiet
from mgeo.terminal import Output, json_text, rows

app = typer.Typer()

EXAMPLES: Mapping[str, tuple[str, ...]] = {
    "verify": (
        "mgeo attitude verify plan.json --runs 500",
        "mgeo attitude verify runs/first --pick best --out runs/first/verification-best.json",
    ),
    "fly": (
        "mgeo attitude fly plan.json --out telemetry.csv --truth truth.json",
        "mgeo attitude fly plan.json --simulator basilisk --vehicle cubesat_6u --seed 2",
        "mgeo attitude fly second.json --after truth.json --out second.csv",
    ),
    "calibrate": (
        "mgeo attitude calibrate telemetry.csv --scenario mine.toml --out calibration",
        "mgeo attitude calibrate telemetry.csv --plan plan.json --mapping columns.toml",
        "mgeo attitude calibrate telemetry.csv --scenario mine.toml --diagnose --fit noise",
    ),
}


@app.command(epilog=epilog("verify", EXAMPLES))
def verify(
    source: Source,
    pick: Pick = None,
    time: Time = None,
    solution: Solution = None,
    runs: Annotated[int, typer.Option(min=2, help="Flights to simulate.")] = 200,
    seed: Annotated[int, typer.Option(min=0, help="Seed of their errors.")] = 1,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="Write the result there [default: of a run into its folder, as "
            "verification-solutionN-seedS.json, for `mgeo report`].",
        ),
    ] = None,
    overwrite: Overwrite = False,
    quiet: Quiet = False,
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Fly a plan many times: does it achieve what it promises?

    If it does not, the exit code is 3. So it is of a plan that breaks a limit of its scenario,
    whatever it achieves, such as the nearest of a run that found none that keeps all. The truth is
    nonlinear, the errors are drawn from the scenario, the filter feeds them back. Of path limits it
    says how often they were broken.
    """
    from mgeo_attitude.commands.files import check_targets, load_plan
    from mgeo_attitude.scenario.validity import OutsideValidity

    from mgeo.store.atomic import write_file
    from mgeo_calibration import verification
    from mgeo_calibration.commands import verify as command

    output = Output(quiet, json)
    with bad_input(USERS):
        check_targets([out], overwrite)
        picked = load_plan(source, pick, time, solution)
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always", OutsideValidity)
            found = verification.verify(picked.plan, runs, seed)
        for warning in caught:
            output.note(f"Note: {warning.message}")
        document = command.verification_document(picked, found, seed)
        command.print_verification(picked, found, output)
        output.result(document)
        if target := out or command.result_file(source, picked, seed):
            write_file(target, f"{json_text(document)}\n".encode())
            output.print(f"written: {target}")
    holds = found.achieved and not document["violations"]
    raise typer.Exit(ExitCode.DONE if holds else ExitCode.INCOMPLETE)


@app.command(epilog=epilog("fly", EXAMPLES))
def fly(
    source: Source,
    pick: Pick = None,
    time: Time = None,
    solution: Solution = None,
    simulator: Annotated[
        Literal["own", "basilisk"],
        typer.Option(
            help="Exact rates, or a rigid body with wheels by Basilisk, which is an extra."
        ),
    ] = "own",
    vehicle: Annotated[
        Literal["paper", "cubesat_6u"] | None,
        typer.Option(help="Body and wheels for Basilisk [default: the scenario's]."),
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of errors and noise.")] = 1,
    after: Annotated[
        Path | None,
        typer.Option(
            metavar="TRUTH.json", help="Go on with the satellite of the flight that wrote this."
        ),
    ] = None,
    until: Annotated[
        float | None, typer.Option(metavar="SECONDS", help="Send down no later samples.")
    ] = None,
    out: Annotated[
        Path, typer.Option(metavar="FILE.csv", help="Telemetry, for `mgeo attitude calibrate`.")
    ] = Path("telemetry.csv"),
    truth: Annotated[
        Path | None,
        typer.Option(metavar="FILE.json", help="Also write what was true at the last sample."),
    ] = None,
    overwrite: Overwrite = False,
    quiet: Quiet = False,
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Fly a plan once, and write what the satellite sends down.

    It is flown to the end of its scenario, unless --until ends it. Attitude and errors are drawn
    from the scenario, unless --after says whose they are; the same seed draws the same for both
    simulators.
    """
    from mgeo_attitude.commands.files import check_targets, load_plan

    from mgeo.store.atomic import to_json, write_file
    from mgeo_calibration.commands import fly as command
    from mgeo_calibration.flight.as_flown import as_flown
    from mgeo_calibration.flight.truth import read_truth, truth_document

    with bad_input(USERS):
        check_targets([out], overwrite, (".csv",))
        check_targets([truth], overwrite, (".json",))
        picked = load_plan(source, pick, time, solution)
        plan = picked.plan
        before = read_truth(after, plan) if after else None
        telemetry = command.simulate_flight(plan, simulator, vehicle, seed, before)
        telemetry = telemetry if until is None else telemetry.until(until)
        document = truth_document(plan, telemetry, simulator, seed)
        compared = as_flown(plan, telemetry)
        telemetry.to_csv(out)
        if truth:
            write_file(truth, to_json(document))
    files = [str(path) for path in (out, truth) if path]
    output = Output(quiet, json)
    command.print_flight(picked, telemetry, compared, simulator, files, output)
    samples = len(telemetry.times)
    output.result(
        {"files": files, "samples": samples, "truth": document, "as_flown": rows(compared)}
    )


@app.command(epilog=epilog("calibrate", EXAMPLES))
def calibrate(
    telemetry: Annotated[
        Path, typer.Argument(metavar="TELEMETRY", help="Table of samples: CSV, or .parquet.")
    ],
    scenario: Annotated[
        str | None,
        typer.Option(
            metavar="FILE.toml|PRESET",
            help="Satellite, orbit and epoch [default: those of --plan].",
        ),
    ] = None,
    plan: Annotated[
        Path | None,
        typer.Option(
            metavar="RUN|PLAN.json", help="Compare with the 1-sigmas that a plan predicted."
        ),
    ] = None,
    pick: Pick = None,
    time: Time = None,
    solution: Solution = None,
    mapping: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.toml",
            help="Columns, units and mounting frames, where they are not the usual ones.",
        ),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Also write JSON, CSV and an HTML report there."),
    ] = None,
    fit: Annotated[
        str | None,
        typer.Option(
            metavar="KEY,...",
            help="Calibrate again with states, such as mag.scale_factor, or noise from the data.",
        ),
    ] = None,
    diagnose: Annotated[
        bool, typer.Option("--diagnose", help="Print all that is tested, not only what fails.")
    ] = False,
    overwrite: Overwrite = False,
    quiet: Quiet = False,
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Calibrate gyro and sensors from telemetry.

    If the innovations do not support it, the exit code is 3. Nothing has to be known of the
    attitude. Outliers are left out, and listed.
    """
    from mgeo_attitude.scenario.validity import Implausible

    from mgeo_calibration.calibration.diagnosis import CannotCalibrate
    from mgeo_calibration.calibration.from_telemetry import calibrate as calibrated
    from mgeo_calibration.calibration.recalibration import calibrate_with
    from mgeo_calibration.calibration.strength_calibration import calibrate_alone
    from mgeo_calibration.commands import calibrate as command
    from mgeo_calibration.telemetry.mapping import TelemetryMapping
    from mgeo_calibration.telemetry.reading import read_telemetry

    output = Output(quiet, json)
    with bad_input(USERS):
        if out:
            command.check_folder(out, overwrite)
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always", Implausible)
            picked = command.flown_plan(plan, pick, time, solution)
            flown = picked.plan if picked else None
            of = command.scenario_of(scenario, flown)
        for line in dict.fromkeys(str(warning.message) for warning in caught):
            output.note(f"Note: {line}")
        read = TelemetryMapping.from_toml(mapping) if mapping else None
        alone = read is not None and read.gyro.holds == "unknown"
        if alone and fit is not None:
            raise ValueError('--fit: expected none with holds = "unknown", which needs an attitude')
        samples = read_telemetry(telemetry, of, read)
        try:
            found = calibrate_alone(of, samples) if alone else calibrated(of, samples, read)
        except CannotCalibrate as refused:
            if diagnose:
                command.report_refusal(refused, output)
            raise
        predicted = found.compare(flown) if flown else None
        first = found
        if fit is not None:
            found = calibrate_with(first, samples, [key.strip() for key in fit.split(",")])
        command.print_calibration(found, predicted, picked, output)
        if diagnose:
            command.print_tests(found, output)
        if found is not first:
            command.print_comparison(first, found, output)
        files = command.write_calibration(found, predicted, out) if out else []
    output.print(*(f"wrote {file}" for file in files))
    output.result(command.calibration_document(found, predicted, files))
    raise typer.Exit(ExitCode.DONE if found.supported else ExitCode.INCOMPLETE)
