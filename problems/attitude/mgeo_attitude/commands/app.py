"""Commands and flags; each command imports what it needs only when it is run."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import typer

from mgeo.cli.completion import among, toml_files
from mgeo.cli.errors import ExitCode, bad_input
from mgeo.cli.examples import epilog
from mgeo.cli.options import Debug, Json, Quiet
from mgeo.cli.output import Output, json_text

app = typer.Typer(
    help="Calibration maneuvers: pick a plan from a front, look at it, verify it, export it."
)

EXAMPLES: Mapping[str, tuple[str, ...]] = {
    "show": (
        "mgeo attitude show runs/attitude-mgeo-directed-seed1",
        "mgeo attitude show runs/attitude-mgeo-directed-seed1 --solution 12",
        "mgeo attitude show runs/attitude-mgeo-directed-seed1 --time 3000 --html plan.html",
        "mgeo attitude show plan.json --json | jq .t_end_s",
    ),
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
    ),
    "check": ("mgeo attitude check mine.toml --plans 50",),
    "schema": ("mgeo attitude schema > scenario.schema.json",),
    "export": (
        "mgeo attitude export runs/first plan.json plan.uplink.csv --pick best",
        "mgeo attitude export plan.json plan.aem --object-name SAT --object-id 2021-015A",
    ),
}

Source = Annotated[
    Path, typer.Argument(metavar="RUN|PLAN.json", help="Folder of `mgeo solve`, or a plan's file.")
]
Pick = Annotated[
    str | None,
    typer.Option(
        metavar="knee|fastest|best",
        help="Solution of the run: where its front bends, its least t_end, its least trace "
        "[default: knee].",
        autocompletion=among(("knee", "fastest", "best")),
    ),
]
Time = Annotated[
    float | None,
    typer.Option(metavar="SECONDS", help="Solution of the run whose t_end is nearest to this."),
]
Solution = Annotated[
    int | None,
    typer.Option(metavar="N", help="Solution of the run by its number, as reports show it."),
]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="Replace existing files.")]

#: Of what a plan is made from everything is the user's: files, scenarios, extras to install.
_USERS = (ValueError, TypeError, OSError, ImportError)


@app.command(epilog=epilog("show", EXAMPLES))
def show(
    source: Source,
    pick: Pick = None,
    time: Time = None,
    solution: Solution = None,
    html: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Also write the plan's figures.")
    ] = None,
    overwrite: Overwrite = False,
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Print a plan: its timeline, and what it teaches the filter.

    Beside it stands what simpler plans would teach, after the plan's own time, with maneuvers as
    long as the plan's in all.
    """
    from mgeo_attitude.commands.files import check_targets, load_plan
    from mgeo_attitude.commands.show import plan_document, print_plan, write_figures

    with bad_input(_USERS):
        check_targets([html], overwrite)
        picked = load_plan(source, pick, time, solution)
        if json:
            Output(json=True).result(plan_document(picked))
        else:
            print_plan(picked, Output())
        if html:
            write_figures(picked.plan, html)


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
            help="Also write the result; `mgeo report` shows RUN/verification*.json.",
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
    from mgeo.files.atomic import write_file
    from mgeo_attitude.commands.files import check_targets, load_plan
    from mgeo_attitude.commands.verify import print_verification, verification_document
    from mgeo_attitude.estimation import OutsideValidity
    from mgeo_attitude.plan import verification

    output = Output(quiet, json)
    with bad_input(_USERS):
        check_targets([out], overwrite)
        picked = load_plan(source, pick, time, solution)
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always", OutsideValidity)
            found = verification.verify(picked.plan, runs, seed)
        for warning in told:
            output.note(f"Note: {warning.message}")
        document = verification_document(picked, found, seed)
    print_verification(picked, found, output)
    output.result(document)
    with bad_input():
        if out:
            write_file(out, f"{json_text(document)}\n".encode())
    holds = found.achieved and not document["violations"]
    raise typer.Exit(ExitCode.DONE if holds else ExitCode.INCOMPLETE)


@app.command(epilog=epilog("export", EXAMPLES))
def export(
    source: Source,
    files: Annotated[
        list[Path],
        typer.Argument(
            metavar="FILE...",
            help="What to write, by suffix: .json (the plan, can be read back), .uplink.csv (start "
            "times, rates, durations), .csv (timeline), .aem (CCSDS attitude ephemeris).",
        ),
    ],
    pick: Pick = None,
    time: Time = None,
    solution: Solution = None,
    object_name: Annotated[
        str, typer.Option(metavar="TEXT", help="AEM: OBJECT_NAME, the spacecraft.")
    ] = "UNKNOWN",
    object_id: Annotated[
        str, typer.Option(metavar="TEXT", help="AEM: OBJECT_ID, its international designator.")
    ] = "UNKNOWN",
    originator: Annotated[
        str, typer.Option(metavar="TEXT", help="AEM: ORIGINATOR, agency or operator.")
    ] = "UNKNOWN",
    aem_version: Annotated[
        str, typer.Option(metavar="1.0|2.0", help="AEM: CCSDS 504.0-B-1 or -B-2.")
    ] = "1.0",
    spacing: Annotated[
        float, typer.Option(metavar="SECONDS", help="AEM: greatest time between attitudes.")
    ] = 1.0,
    overwrite: Overwrite = False,
    force: Annotated[
        bool,
        typer.Option(
            "--force", help="Write a plan that violates constraints, too; its files then say so."
        ),
    ] = False,
    quiet: Quiet = False,
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Write a plan to files, each as a whole or not at all.

    A plan that violates a constraint of its scenario is refused, unless told otherwise.
    """
    from mgeo.files.atomic import write_file
    from mgeo_attitude.commands.files import check_constraints, check_targets, load_plan
    from mgeo_attitude.plan.files import SUFFIXES, plan_text

    with bad_input(_USERS):
        check_targets(files, overwrite, SUFFIXES)
        picked = load_plan(source, pick, time, solution)
        check_constraints(picked, force)
        aem: dict[str, Any] = {
            "object_name": object_name,
            "object_id": object_id,
            "originator": originator,
            "version": aem_version,
            "spacing": spacing,
        }
        texts = {path: plan_text(picked.plan, path, aem) for path in files}
        output = Output(quiet, json)
        for told in () if quiet else picked.doubts() + picked.lateness():
            output.note(told)
        for path, text in texts.items():
            write_file(path, text.encode())
            output.print(f"wrote {path}")
    output.result({"files": [str(path) for path in texts]})


@app.command(epilog=epilog("fly", EXAMPLES))
def fly(
    source: Source,
    pick: Pick = None,
    time: Time = None,
    solution: Solution = None,
    simulator: Annotated[
        str,
        typer.Option(
            metavar="own|basilisk",
            help="Exact rates, or a rigid body with wheels by Basilisk, which is an extra.",
            autocompletion=among(("own", "basilisk")),
        ),
    ] = "own",
    vehicle: Annotated[
        str | None,
        typer.Option(
            metavar="paper|cubesat_6u",
            help="Body and wheels for Basilisk [default: the scenario's].",
            autocompletion=among(("paper", "cubesat_6u")),
        ),
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
    from mgeo_attitude.commands import fly as command
    from mgeo_attitude.commands.files import check_targets, load_plan

    with bad_input(_USERS):
        check_targets([out], overwrite, (".csv",))
        check_targets([truth], overwrite, (".json",))
        picked = load_plan(source, pick, time, solution)
        plan = picked.plan
        before = command.read_truth(after, plan) if after else None
        telemetry = command.flown(plan, simulator, vehicle, seed, before)
        telemetry = telemetry if until is None else telemetry.until(until)
        document = command.truth_document(plan, telemetry, simulator, seed)
        files = command.write_flight(telemetry, out, truth, document)
    output = Output(quiet, json)
    command.print_flight(picked, telemetry, simulator, files, output)
    output.result({"files": files, "samples": len(telemetry.times), "truth": document})


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
            autocompletion=toml_files,
        ),
    ] = None,
    plan: Annotated[
        Path | None,
        typer.Option(
            metavar="RUN|PLAN.json", help="Compare with the 1-sigmas that a plan promised."
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
    overwrite: Overwrite = False,
    quiet: Quiet = False,
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Calibrate gyro and sensors from telemetry.

    If the innovations do not support it, the exit code is 3. Nothing has to be known of the
    attitude. Outliers are left out, and listed.
    """
    from mgeo_attitude.calibration import calibrate as calibrated
    from mgeo_attitude.commands import calibrate as command
    from mgeo_attitude.flight import TelemetryMapping

    with bad_input(_USERS):
        if out:
            command.check_folder(out, overwrite)
        picked = command.flown_plan(plan, pick, time, solution)
        flown = picked.plan if picked else None
        read = TelemetryMapping.from_toml(mapping) if mapping else None
        found = calibrated(command.scenario_of(scenario, flown), telemetry, read)
        promised = found.compare(flown) if flown else None
    output = Output(quiet, json)
    command.print_calibration(found, promised, picked, output)
    files: list[str] = []
    try:
        with bad_input():
            files += command.write_calibration(found, promised, out) if out else []
        for file in files:
            output.print(f"wrote {file}")
    finally:  # what was found is told all the same
        output.result(command.calibration_document(found, promised, files))
    raise typer.Exit(ExitCode.DONE if found.supported else ExitCode.INCOMPLETE)


@app.command(epilog=epilog("check", EXAMPLES))
def check(
    scenario: Annotated[
        str,
        typer.Argument(
            metavar="FILE.toml|PRESET", help="Satellite and orbit.", autocompletion=toml_files
        ),
    ],
    plans: Annotated[int, typer.Option(min=1, help="Random plans, a second each.")] = 10,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the plans.")] = 1,
    quiet: Quiet = False,
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Check the compiled filter of a scenario against filterpy, on random plans.

    If they differ, the exit code is 3.
    """
    from mgeo_attitude.commands import check as command
    from mgeo_attitude.commands.calibrate import scenario_of

    with bad_input(_USERS):
        of = scenario_of(scenario, None)
        found = command.compare_filters(of, plans, seed)
    output = Output(quiet, json)
    output.print(command.conclusion(of, found))
    output.result(vars(found))
    raise typer.Exit(ExitCode.DONE if command.agrees(found) else ExitCode.INCOMPLETE)


@app.command(epilog=epilog("schema", EXAMPLES))
def schema(debug: Debug = False) -> None:
    """Print the JSON Schema of scenario files.

    Editors complete and check them by it.
    """
    from mgeo_attitude.scenario import scenario_schema

    typer.echo(json_text(scenario_schema()))
