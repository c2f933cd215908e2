"""Commands and flags; each command imports what it needs only when it is run."""

from __future__ import annotations

from importlib.metadata import version
from pathlib import Path
from typing import Annotated

import typer

from .errors import one_line_errors

app = typer.Typer(
    name="mgeo-attitude",
    help="Calibration maneuvers: pick a plan from a front, look at it, verify it, export it.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)

#: Exit code of `verify` for a plan that promises too much; bad input is `errors.BAD_INPUT`.
NOT_ACHIEVED = 1

Source = Annotated[
    Path, typer.Argument(metavar="RUN|PLAN.json", help="Folder of `mgeo solve`, or a plan's file.")
]
Pick = Annotated[
    str | None,
    typer.Option(
        metavar="knee|fastest|best",
        help="Solution of the run: the bend of its front, its least t_end, its least trace "
        "[default: knee].",
    ),
]
Time = Annotated[
    float | None,
    typer.Option(metavar="SECONDS", help="Solution of the run whose t_end is nearest to this."),
]
Debug = Annotated[bool, typer.Option("--debug", help="Show the traceback of an error.")]


def main() -> None:
    """Entry point of the command ``mgeo-attitude``."""
    app()


def _print_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"mgeo-attitude {version('mgeo-attitude')}")
        raise typer.Exit


@app.callback()
def _root(
    show_version: Annotated[
        bool,
        typer.Option(
            "--version", callback=_print_version, is_eager=True, help="Print the version and exit."
        ),
    ] = False,
) -> None:
    pass


@app.command()
def show(
    source: Source,
    pick: Pick = None,
    time: Time = None,
    html: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Also write the plan's figures.")
    ] = None,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Replace an existing file.")
    ] = False,
    debug: Debug = False,
) -> None:
    """Print a plan: its timeline, what it teaches the filter, and what simpler plans would.

    The comparison is after the plan's own time, with maneuvers as long as the plan's in all.
    """
    from .files import checked_targets
    from .show import print_plan, write_figures
    from .source import load_plan

    with one_line_errors(debug):
        checked_targets([html] if html else [], overwrite)
        plan = load_plan(source, pick, time)
        print_plan(plan)
        if html:
            write_figures(plan, html)


@app.command()
def verify(
    source: Source,
    pick: Pick = None,
    time: Time = None,
    runs: Annotated[int, typer.Option(min=2, help="Flights to simulate.")] = 200,
    seed: Annotated[int, typer.Option(min=0, help="Seed of their errors.")] = 1,
    json: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="Also write the result; `mgeo report` shows RUN/verification*.json.",
        ),
    ] = None,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Replace an existing file.")
    ] = False,
    debug: Debug = False,
) -> None:
    """Fly a plan many times in simulation; exit with 1 if it does not achieve what it promises.

    The truth is nonlinear, the errors are drawn from the scenario, the filter feeds them back.
    """
    from .files import checked_targets
    from .source import load_plan
    from .verify import print_verification

    with one_line_errors(debug):
        checked_targets([json] if json else [], overwrite)
        achieved = print_verification(load_plan(source, pick, time), runs, seed, json)
    raise typer.Exit(0 if achieved else NOT_ACHIEVED)


@app.command()
def export(
    source: Source,
    files: Annotated[
        list[Path],
        typer.Argument(
            metavar="FILE...",
            help="What to write, by suffix: .json (the plan, can be read back), .csv (timeline), "
            ".aem (CCSDS attitude ephemeris).",
        ),
    ],
    pick: Pick = None,
    time: Time = None,
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
        str, typer.Option(metavar="2.0|1.0", help="AEM: CCSDS 504.0-B-2 or -B-1.")
    ] = "2.0",
    spacing: Annotated[
        float, typer.Option(metavar="SECONDS", help="AEM: greatest time between attitudes.")
    ] = 1.0,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace existing files.")] = False,
    debug: Debug = False,
) -> None:
    """Write a plan to files, each as a whole or not at all."""
    from .files import checked_targets, contents, write_all
    from .source import load_plan

    with one_line_errors(debug):
        checked_targets(files, overwrite, known_only=True)
        plan = load_plan(source, pick, time)
        texts = contents(
            plan,
            files,
            object_name=object_name,
            object_id=object_id,
            originator=originator,
            version=aem_version,
            spacing=spacing,
        )
        for path in write_all(texts):
            typer.echo(f"wrote {path}")
