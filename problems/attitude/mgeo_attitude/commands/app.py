"""Commands and options of ``mgeo attitude``.

Each command imports its modules when it runs, so that the command line starts quickly.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from mgeo.cli.errors import ExitCode, InputError, convert_input_errors
from mgeo.cli.help_text import format_examples
from mgeo.cli.options import Debug, Json, Quiet, complete_from
from mgeo.terminal import Output, format_json
from mgeo_attitude.calibration_package import COMMANDS, INSTALL_COMMAND
from mgeo_attitude.export_formats import FORMATS
from mgeo_attitude.plan_sections import FIRST_PAGE, SECTION_KEYS

if TYPE_CHECKING:
    from mgeo_attitude.documents import CheckDocument, ExportDocument

app = typer.Typer(help="Calibration maneuvers: select a plan of a front, analyze it and export it.")

EXAMPLES: Mapping[str, tuple[str, ...]] = {
    "show": (
        "mgeo attitude show runs/attitude-mgeo-directed-seed1",
        "mgeo attitude show runs/attitude-mgeo-directed-seed1 --solution 12",
        "mgeo attitude show runs/attitude-mgeo-directed-seed1 --time 3000 --html plan.html",
        "mgeo attitude show plan.json --section budget --section improvements",
        "mgeo attitude show plan.json --json | jq .summary.t_end_s",
    ),
    "export": (
        "mgeo attitude export runs/first plan.json plan.uplink.csv --pick min-trace",
        "mgeo attitude export plan.json plan.aem --object-name SAT --object-id 2021-015A",
        "mgeo attitude export plan.json plan.aem --aem-rates none --aem-frame EME2000",
        "mgeo attitude export plan.json plan.bc plan.tsc --naif-id -123",
    ),
    "check": ("mgeo attitude check mine.toml --plans 50",),
    "schema": ("mgeo attitude schema > scenario.schema.json",),
}


Source = Annotated[
    Path, typer.Argument(metavar="RUN|PLAN.json", help="Run folder of `mgeo solve`, or plan file.")
]
Pick = Annotated[
    str | None,
    typer.Option(
        metavar="knee|min-time|min-trace",
        help="Plan of the run folder: knee of the front, shortest plan, or plan with the smallest "
        "trace of the covariance [default: knee].",
        autocompletion=complete_from(("knee", "min-time", "min-trace")),
    ),
]
Time = Annotated[
    float | None,
    typer.Option(
        metavar="SECONDS", help="Plan of the run folder whose end is nearest to this time."
    ),
]
Solution = Annotated[
    int | None,
    typer.Option(
        metavar="N",
        help="Plan of the run folder with this number, which `mgeo solve` and reports print: its "
        "row in front.csv, counted from 0.",
    ),
]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="Replace existing files.")]

#: Exceptions that are due to the user's input: files, scenarios and missing extras.
USER_ERRORS = (ValueError, TypeError, OSError, ImportError)

#: Largest relative difference of a variance between the compiled filter and filterpy.
TOLERANCE = 1e-9


@app.command(epilog=format_examples("show", EXAMPLES))
def show(
    source: Source,
    pick: Pick = None,
    time: Time = None,
    solution: Solution = None,
    section: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME",
            help="Section to print; can be repeated: "
            + ", ".join(SECTION_KEYS)
            + f" [default: {', '.join(FIRST_PAGE)}].",
            autocompletion=complete_from(SECTION_KEYS),
        ),
    ] = None,
    all_sections: Annotated[bool, typer.Option("--all", help="Print all sections.")] = False,
    html: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Also write a page with all sections and figures."),
    ] = None,
    overwrite: Overwrite = False,
    quiet: Quiet = False,
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Print a plan: summary, constraints, timeline, predicted accuracy and accuracy drivers.

    JSON output has all sections, unless --section selects some.
    """
    from mgeo.validation.arguments import validate_choice
    from mgeo_attitude.commands.files import check_targets, load_plan
    from mgeo_attitude.commands.show import build_plan_document, print_plan, write_plan_page

    with convert_input_errors(USER_ERRORS):
        for name in section or ():
            validate_choice("--section", name, SECTION_KEYS)
        check_targets([html], overwrite)
        picked = load_plan(source, pick, time, solution)
        output = Output(quiet, json)
        keys = section or (SECTION_KEYS if all_sections else FIRST_PAGE)
        if output.is_text:
            print_plan(picked, keys, output)
        if json:
            output.print_document(build_plan_document(picked, section or SECTION_KEYS))
        if html:
            write_plan_page(picked.plan, html)
            output.print(f"Written: {html}")


@app.command(epilog=format_examples("export", EXAMPLES))
def export(
    source: Source,
    files: Annotated[
        list[Path],
        typer.Argument(
            metavar="FILE",
            help="Files to write; the suffix selects the format: "
            + ", ".join(f"{each.suffix} ({each.name})" for each in FORMATS)
            + ".",
        ),
    ],
    pick: Pick = None,
    time: Time = None,
    solution: Solution = None,
    object_name: Annotated[
        str, typer.Option(metavar="TEXT", help="AEM: OBJECT_NAME, name of the spacecraft.")
    ] = "UNKNOWN",
    object_id: Annotated[
        str, typer.Option(metavar="TEXT", help="AEM: OBJECT_ID, international designator.")
    ] = "UNKNOWN",
    originator: Annotated[
        str, typer.Option(metavar="TEXT", help="AEM: ORIGINATOR, agency or operator.")
    ] = "UNKNOWN",
    aem_version: Annotated[
        str, typer.Option(metavar="1.0|2.0", help="AEM: CCSDS 504.0-B-1 or -B-2.")
    ] = "1.0",
    aem_rates: Annotated[
        str,
        typer.Option(
            metavar="given|none",
            help="AEM: none omits the rates, which are derivatives of the quaternion in version "
            "1.0, and body rates in version 2.0.",
        ),
    ] = "given",
    aem_frame: Annotated[
        str, typer.Option(metavar="GCRF|EME2000", help="AEM: REF_FRAME_A, the inertial frame.")
    ] = "GCRF",
    naif_id: Annotated[
        int, typer.Option(metavar="N", help="SPICE: spacecraft identifier, below 0.")
    ] = -999,
    spacing: Annotated[
        float, typer.Option(metavar="SECONDS", help="Largest time between attitudes.")
    ] = 1.0,
    overwrite: Overwrite = False,
    force: Annotated[
        bool,
        typer.Option(
            "--force", help="Also write a plan that violates constraints; its files list them."
        ),
    ] = False,
    quiet: Quiet = False,
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Export a plan to files. The suffix of each file name selects the format.

    A plan that violates a constraint of its scenario is rejected, unless --force is given.
    """
    from mgeo.store.atomic import write_file
    from mgeo_attitude.commands.export import print_export
    from mgeo_attitude.commands.files import check_constraints, check_targets, load_plan
    from mgeo_attitude.plan.files import build_plan_content
    from mgeo_attitude.plan.summary import (
        list_warnings,
        warn_of_final_rate,
        warn_of_late_convergence,
    )

    with convert_input_errors(USER_ERRORS):
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
        contents = {path: build_plan_content(picked.plan, path, options) for path in files}
        lists = (list_warnings, warn_of_late_convergence, warn_of_final_rate)
        warnings = [line for list_lines in lists for line in list_lines(picked.plan)]
        output = Output(quiet, json)
        for path, content in contents.items():
            write_file(path, content)
        if output.is_text:
            print_export(picked, contents, warnings, spacing, output)
    exported: ExportDocument = {"files": list(map(str, contents)), "warnings": warnings}
    output.print_document(exported)


@app.command(epilog=format_examples("check", EXAMPLES))
def check(
    scenario: Annotated[
        str,
        typer.Argument(metavar="FILE.toml|PRESET", help="Scenario file or preset."),
    ],
    plans: Annotated[int, typer.Option(min=1, help="Random plans, about 1 s each.")] = 10,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the plans.")] = 1,
    quiet: Quiet = False,
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Compare the compiled Kalman filter with the library filterpy for random plans of a scenario.

    The exit code is 3 if the results differ.
    """
    import numpy as np

    from mgeo.plugins.problems import read_scenario
    from mgeo_attitude.filter.reference import compare_filters
    from mgeo_attitude.plan.run_folder import PROBLEM
    from mgeo_attitude.problem import AttitudeManeuverProblem

    with convert_input_errors(USER_ERRORS):
        problem = AttitudeManeuverProblem.from_options(read_scenario(PROBLEM, scenario))
        rng = np.random.default_rng(seed)
        designs = rng.uniform(problem.xl, problem.xu, (plans, problem.n_var))
        difference = compare_filters(problem.model, designs)
    output = Output(quiet, json)
    agrees = difference.is_within(TOLERANCE)
    verdict = "agrees" if agrees else "does NOT agree"
    ends = "equal" if difference.has_equal_ends else "DIFFERENT"
    output.print_text(
        f"The compiled filter {verdict} with filterpy: the largest relative difference of a "
        f"variance is {difference.max_difference:.2g}, with a tolerance of {TOLERANCE:g}. "
        f"The convergence times are {ends}.",
        f"Compared: {difference.n_designs} random plans of {problem.scenario.name}, "
        f"{difference.n_samples:,} filter steps.",
    )
    document: CheckDocument = {
        "agrees": agrees,
        "tolerance": TOLERANCE,
        "n_designs": difference.n_designs,
        "n_samples": difference.n_samples,
        "has_equal_ends": difference.has_equal_ends,
        "max_difference": difference.max_difference,
    }
    output.print_document(document)
    raise typer.Exit(ExitCode.SUCCESS if agrees else ExitCode.INCOMPLETE)


@app.command(epilog=format_examples("schema", EXAMPLES))
def schema(debug: Debug = False) -> None:
    """Print the JSON Schema of scenario files, for completion and validation in editors."""
    from mgeo_attitude.scenario.schema import build_scenario_schema

    typer.echo(format_json(build_scenario_schema()))


def _request_installation(ctx: typer.Context) -> None:
    raise InputError(
        f"{ctx.command_path} is a command of the package mgeo-calibration, which is not installed. "
        f"Install it with {INSTALL_COMMAND}"
    )


# The package mgeo-calibration replaces these commands.
for _name in COMMANDS:
    app.command(
        _name,
        hidden=True,
        add_help_option=False,
        context_settings={"allow_extra_args": True, "ignore_unknown_options": True},
    )(_request_installation)
