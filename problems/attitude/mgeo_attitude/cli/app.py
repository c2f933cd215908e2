"""Commands and flags; each command imports what it needs only when it is run."""

from __future__ import annotations

from importlib.metadata import version
from pathlib import Path
from typing import Annotated

import typer

from .errors import EXIT_CODES, NOT_ACHIEVED, Commands, printable, remember_debug
from .examples import epilog

app = typer.Typer(
    name="mgeo-attitude",
    cls=Commands,
    help="Calibration maneuvers: pick a plan from a front, look at it, verify it, export it.",
    no_args_is_help=True,
    epilog="\n".join(
        ["\b", "Exit codes:", *(f"{code:5}  {text}" for code, text in EXIT_CODES.items())]
    ),
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["--help", "-h"]},
)

Source = Annotated[
    Path, typer.Argument(metavar="RUN|PLAN.json", help="Folder of `mgeo solve`, or a plan's file.")
]
Pick = Annotated[
    str | None,
    typer.Option(
        metavar="knee|fastest|best",
        help="Solution of the run: the bend of its front, its least t_end, its least trace "
        "[default: knee].",
        autocompletion=lambda incomplete: [
            name for name in ("knee", "fastest", "best") if name.startswith(incomplete)
        ],
    ),
]
Time = Annotated[
    float | None,
    typer.Option(metavar="SECONDS", help="Solution of the run whose t_end is nearest to this."),
]
Json = Annotated[
    bool, typer.Option("--json", help="Print the result as one JSON document, for scripts.")
]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Print errors only.")]
Debug = Annotated[
    bool,
    typer.Option("--debug", callback=remember_debug, help="Show the traceback of an error."),
]


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


@app.command(epilog=epilog("show"))
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
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Print a plan: its timeline, what it teaches the filter, and what simpler plans would.

    The comparison is after the plan's own time, with maneuvers as long as the plan's in all.
    """
    from .documents import plan_document, print_document
    from .files import checked_targets
    from .show import print_plan, write_figures
    from .source import load_plan

    checked_targets([html] if html else [], overwrite)
    plan = load_plan(source, pick, time)
    if json:
        print_document(plan_document(plan))
    else:
        print_plan(plan)
    if html:
        write_figures(plan, html)


@app.command(epilog=epilog("schema"))
def schema() -> None:
    """Print the JSON Schema of scenario files, by which editors complete and check them."""
    from ..scenario import scenario_schema
    from .documents import print_document

    print_document(scenario_schema())


@app.command("verify", epilog=epilog("verify"))
def verify_plan(
    source: Source,
    pick: Pick = None,
    time: Time = None,
    runs: Annotated[int, typer.Option(min=2, help="Flights to simulate.")] = 200,
    seed: Annotated[int, typer.Option(min=0, help="Seed of their errors.")] = 1,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="Also write the result; `mgeo report` shows RUN/verification*.json.",
        ),
    ] = None,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Replace an existing file.")
    ] = False,
    quiet: Quiet = False,
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Fly a plan many times in simulation; exit with 3 if it does not achieve what it promises.

    The truth is nonlinear, the errors are drawn from the scenario, the filter feeds them back. Of
    keep-out cones it says how often the Sun was inside.
    """
    from ..plan.verification import verify
    from .documents import print_document
    from .files import checked_targets
    from .source import load_plan
    from .verify import print_verification, verification_document, write_document

    checked_targets([out] if out else [], overwrite)
    plan = load_plan(source, pick, time)
    found = verify(plan, runs, seed)
    document = verification_document(plan, found, seed)
    if out:
        write_document(document, out)
    if json:
        print_document(document)
    elif not quiet:
        print_verification(plan, found)
    raise typer.Exit(0 if found.achieved else NOT_ACHIEVED)


@app.command(epilog=epilog("export"))
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
    from .documents import print_document
    from .files import check_constraints, checked_targets, contents, write_all
    from .source import load_plan

    checked_targets(files, overwrite, known_only=True)
    plan = load_plan(source, pick, time)
    check_constraints(plan, force)
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
        if not (quiet or json):
            typer.echo(f"wrote {printable(str(path))}")
    if json:
        print_document({"files": [str(path) for path in texts]})
