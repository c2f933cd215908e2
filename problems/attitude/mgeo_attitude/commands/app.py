"""Commands and flags; each command imports what it needs only when it is run."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import typer

from mgeo.cli.app import epilog
from mgeo.cli.errors import ExitCode, bad_input
from mgeo.cli.options import Debug, Json, Quiet, among
from mgeo.terminal import Output, json_text
from mgeo_attitude.export_formats import FORMATS

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
    "export": (
        "mgeo attitude export runs/first plan.json plan.uplink.csv --pick best",
        "mgeo attitude export plan.json plan.aem --object-name SAT --object-id 2021-015A",
        "mgeo attitude export plan.json plan.aem --aem-rates none --aem-frame EME2000",
        "mgeo attitude export plan.json plan.bc plan.tsc --naif-id -123",
    ),
    "check": ("mgeo attitude check mine.toml --plans 50",),
    "schema": ("mgeo attitude schema > scenario.schema.json",),
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
USERS = (ValueError, TypeError, OSError, ImportError)

#: Largest relative difference of a variance between the compiled filter and filterpy.
TOLERANCE = 1e-9


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
    quiet: Quiet = False,
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Print a plan: its timeline, and what it teaches the filter.

    Beside it stands what simpler plans would teach, after the plan's own time, with maneuvers as
    long as the plan's in all.
    """
    from mgeo_attitude.commands.files import check_targets, load_plan
    from mgeo_attitude.commands.show import plan_document, print_plan, write_figures

    with bad_input(USERS):
        check_targets([html], overwrite)
        picked = load_plan(source, pick, time, solution)
        output = Output(quiet, json)
        if output.for_people:
            print_plan(picked, output)
        if json:
            output.result(plan_document(picked))
        if html:
            write_figures(picked.plan, html)
            output.print(f"wrote {html}")


@app.command(epilog=epilog("export", EXAMPLES))
def export(
    source: Source,
    files: Annotated[
        list[Path],
        typer.Argument(
            metavar="FILE...",
            help="What to write, by suffix: "
            + ", ".join(f"{each.suffix} ({each.name})" for each in FORMATS)
            + ".",
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
    aem_rates: Annotated[
        str,
        typer.Option(metavar="given|none", help="AEM: none for readers of plain quaternions."),
    ] = "given",
    aem_frame: Annotated[
        str, typer.Option(metavar="GCRF|EME2000", help="AEM: the frame that attitudes are from.")
    ] = "GCRF",
    naif_id: Annotated[
        int, typer.Option(metavar="N", help="SPICE: the spacecraft's, below 0.")
    ] = -999,
    spacing: Annotated[
        float, typer.Option(metavar="SECONDS", help="Greatest time between attitudes.")
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
    from mgeo.store.atomic import write_file
    from mgeo_attitude.commands.files import check_constraints, check_targets, load_plan
    from mgeo_attitude.plan.files import plan_content

    with bad_input(USERS):
        check_targets(files, overwrite, tuple(each.suffix for each in FORMATS))
        picked = load_plan(source, pick, time, solution)
        if not force:
            check_constraints(picked.plan)
        options: dict[str, Any] = {
            "object_name": object_name,
            "object_id": object_id,
            "originator": originator,
            "version": aem_version,
            "rates": aem_rates,
            "frame": aem_frame,
            "naif_id": naif_id,
            "spacing": spacing,
        }
        contents = {path: plan_content(picked.plan, path, options) for path in files}
        output = Output(quiet, json)
        for told in () if quiet else picked.doubts() + picked.lateness():
            output.note(told)
        for path, content in contents.items():
            write_file(path, content)
            output.print(f"wrote {path}")
    output.result({"files": [str(path) for path in contents]})


@app.command(epilog=epilog("check", EXAMPLES))
def check(
    scenario: Annotated[
        str,
        typer.Argument(metavar="FILE.toml|PRESET", help="Satellite and orbit."),
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
    import numpy as np

    from mgeo.plugins.problems import read_scenario
    from mgeo_attitude.filter.reference import agreement
    from mgeo_attitude.plan.run_folder import PROBLEM
    from mgeo_attitude.problem import AttitudeManeuverProblem

    with bad_input(USERS):
        problem = AttitudeManeuverProblem.from_options(read_scenario(PROBLEM, scenario))
        rng = np.random.default_rng(seed)
        designs = rng.uniform(problem.xl, problem.xu, (plans, problem.n_var))
        found = agreement(problem.model, designs)
    output = Output(quiet, json)
    output.print(f"{problem.scenario.name}: {found}, {TOLERANCE:g} allowed")
    output.result(vars(found))
    raise typer.Exit(ExitCode.DONE if found.within(TOLERANCE) else ExitCode.INCOMPLETE)


@app.command(epilog=epilog("schema", EXAMPLES))
def schema(debug: Debug = False) -> None:
    """Print the JSON Schema of scenario files.

    Editors complete and check them by it.
    """
    from mgeo_attitude.scenario.schema import scenario_schema

    typer.echo(json_text(scenario_schema()))
