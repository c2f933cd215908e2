"""The commands; each imports what it needs only when it is run."""

from __future__ import annotations

import os
from importlib.metadata import version
from pathlib import Path
from typing import Annotated, Literal

import typer

from mgeo.cli import options
from mgeo.cli.commands import RootCommands
from mgeo.cli.errors import ExitCode, bad_input
from mgeo.cli.examples import epilog
from mgeo.cli.output import Output

app = typer.Typer(
    name="mgeo",
    cls=RootCommands,
    help="Multiobjective generalized extremal optimization of installed problems.",
    epilog="\n".join(["\b", "Exit codes:", *(f"{c.value:5}  {c.meaning}" for c in ExitCode)]),
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["--help", "-h"]},
)


def main() -> None:
    """Entry point of the command ``mgeo``."""
    app()


def _print_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"mgeo {version('mgeo')}")
        raise typer.Exit


@app.callback()
def _root(
    show_version: Annotated[
        bool,
        typer.Option(
            "--version", callback=_print_version, is_eager=True, help="Print the version and exit."
        ),
    ] = False,
    no_color: Annotated[
        bool, typer.Option("--no-color", help="No colors, as with NO_COLOR in the environment.")
    ] = False,
) -> None:
    if no_color:
        os.environ["NO_COLOR"] = "1"


@app.command(cls=options.Solving, epilog=epilog("solve"))
def solve(
    problem: options.Problem,
    scenario: options.Scenario = None,
    algorithm: options.Algorithm = "mgeo-real",
    sigma: options.Sigma = None,
    tau: options.Tau = None,
    walkers: options.Walkers = None,
    perturbation: options.Perturbation = None,
    population: options.Population = None,
    settings: options.Settings = None,
    evaluations: options.Budget = None,
    seed: options.Seed = 1,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR", help="Folder to write [default: runs/PROBLEM-ALGORITHM-seedSEED]."
        ),
    ] = None,
    overwrite: options.Overwrite = False,
    record: options.Record = False,
    dry_run: options.DryRun = False,
    json: options.Json = False,
    quiet: options.Quiet = False,
    debug: options.Debug = False,
) -> None:
    """Search the Pareto front of a problem and write it to a folder.

    The folder gets front.csv, run.json (how to run it again) and front.html. Ctrl-C ends the run
    and keeps what was found; a second one does so without waiting for the generation under way.
    A run of the MGEO family keeps itself in run.checkpoint while it goes on: see `mgeo resume`.
    """
    from mgeo.cli.parameters import parse_numbers, parse_settings, parse_value
    from mgeo.cli.solve import Request, run

    with bad_input():
        given = {
            "sigma": parse_numbers("--sigma", sigma) if sigma is not None else None,
            "tau": parse_value(tau) if tau is not None else None,
            "n_walkers": walkers,
            "perturbation": perturbation,
            "population": population,
            **parse_settings(settings or []),
        }
    request = Request(
        problem=problem,
        scenario=scenario,
        algorithm=algorithm,
        parameters={key: value for key, value in given.items() if value is not None},
        evaluations=evaluations,
        seed=seed,
        out=out or Path("runs", f"{problem}-{algorithm}-seed{seed}"),
        overwrite=overwrite,
        record=record,
        dry_run=dry_run,
    )
    raise typer.Exit(run(request, Output(quiet, json)))


@app.command(epilog=epilog("resume"))
def resume(
    folder: options.Unfinished,
    evaluations: Annotated[
        int | None,
        typer.Option(min=1, help="New budget, counted from the beginning of the run."),
    ] = None,
    generations: Annotated[
        int | None, typer.Option(min=1, help="New budget, in generations from the beginning.")
    ] = None,
    check: Annotated[
        bool,
        typer.Option(
            "--check/--no-check",
            help="Evaluate a few points again first, and refuse a problem that has changed.",
        ),
    ] = True,
    json: options.Json = False,
    quiet: options.Quiet = False,
    debug: options.Debug = False,
) -> None:
    """Go on with a run that was interrupted or killed, or make a finished one longer.

    It goes on from run.checkpoint in the folder, exactly as the run would have done, and writes
    the same files.
    """
    from mgeo.cli.resume import run

    raise typer.Exit(run(folder, evaluations, generations, check, Output(quiet, json)))


@app.command(epilog=epilog("report"))
def report(
    folder: options.Finished,
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="File to write [default: DIR/report.html].")
    ] = None,
    png: Annotated[
        bool, typer.Option("--png", help="Also write the figures as PNG, into figures beside FILE.")
    ] = False,
    pdf: Annotated[
        bool, typer.Option("--pdf", help="Also write the figures as PDF, into figures beside FILE.")
    ] = False,
    json: options.Json = False,
    quiet: options.Quiet = False,
    debug: options.Debug = False,
) -> None:
    """Write one HTML file about a run, to be attached to a review.

    It shows what was run, the front and the plan of each of its points, and opens without a
    network. Pictures are of the front, the hypervolume, and the knee and the best solutions; they
    need kaleido (pip install 'mgeo[png]') and Chrome or Chromium.
    """
    from mgeo.cli.report import run

    run(
        folder,
        out,
        [kind for kind, wanted in (("png", png), ("pdf", pdf)) if wanted],
        Output(quiet, json),
    )


@app.command(epilog=epilog("problems"))
def problems(json: options.Json = False, debug: options.Debug = False) -> None:
    """List the installed problems."""
    from mgeo.cli.problems import list_problems

    list_problems(Output(json=json))


@app.command(epilog=epilog("study"))
def study(
    file: options.StudyFile,
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Folder to write [default: studies/FILE].")
    ] = None,
    evaluations: Annotated[
        int | None, typer.Option(min=1, help="Another budget than the file's.")
    ] = None,
    seeds: Annotated[
        int | None, typer.Option(min=1, help="Only the first so many seeds, or more.")
    ] = None,
    jobs: Annotated[int, typer.Option(help="Processes; -1 for one per processor.")] = -1,
    cluster: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="Scheduler of a Dask cluster to run on.")
    ] = None,
    dry_run: options.DryRun = False,
    json: options.Json = False,
    quiet: options.Quiet = False,
    debug: options.Debug = False,
) -> None:
    """Compare algorithms as a file says, and write tables and figures.

    Finished runs are kept in the folder: a study that was interrupted goes on when the same
    command is given again.
    """
    from mgeo.cli.study import Request, run

    request = Request(file, out, evaluations, seeds, jobs, cluster, dry_run)
    raise typer.Exit(run(request, Output(quiet, json)))


@app.command(epilog=epilog("schema"))
def schema(
    kind: Annotated[Literal["study"], typer.Argument(help="What the files are.")],
    debug: options.Debug = False,
) -> None:
    """Print a JSON Schema, by which editors complete and check files.

    In editors that know Taplo, a file names it in its first line: #:schema ./study.schema.json
    """
    from mgeo.studies.schema import study_schema

    typer.echo(study_schema())
