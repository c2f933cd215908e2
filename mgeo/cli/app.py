"""Commands and flags; each command imports what it needs only when it is run."""

from __future__ import annotations

from importlib.metadata import version
from pathlib import Path
from typing import Annotated

import typer

from mgeo.cli.errors import one_line_errors

app = typer.Typer(
    name="mgeo",
    help="Multiobjective generalized extremal optimization of installed problems.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)

Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Print errors only.")]
Debug = Annotated[bool, typer.Option("--debug", help="Show the traceback of an error.")]


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
) -> None:
    pass


@app.command()
def solve(
    problem: Annotated[str, typer.Argument(help="Name of a problem (see `mgeo problems`).")],
    scenario: Annotated[
        str | None,
        typer.Option(
            metavar="FILE.toml|PRESET", help="Options of the problem: a file, or a preset's name."
        ),
    ] = None,
    algorithm: Annotated[
        str,
        typer.Option(
            metavar="NAME",
            help="mgeo-real, mgeo-real2, mgeo-canonical, mgeo-var, mgeo-directed, or one of "
            "pymoo's: nsga2, nsga3, u-nsga3, spea2, sms-emoa, age-moea2, moead, ctaea, gde3, "
            "nsde, mopso-cd, cmopso, rvea, random.",
        ),
    ] = "mgeo-real",
    sigma: Annotated[
        str | None,
        typer.Option(
            metavar="NUMBER[,NUMBER...]",
            help="mgeo-real, -real2: standard deviation of the perturbation, one or one per "
            "variable [default: 1.0].",
        ),
    ] = None,
    tau: Annotated[
        str | None,
        typer.Option(
            metavar="NUMBER|a-geo1|a-geo2",
            help="mgeo-...: exponent of the ranking, or a rule by which it adapts [default: 3.0].",
        ),
    ] = None,
    runs: Annotated[
        int | None, typer.Option(help="mgeo-...: independent walkers [default: 30].")
    ] = None,
    perturbation: Annotated[
        str | None,
        typer.Option(
            metavar="absolute|relative|range",
            help="mgeo-real, -real2: what sigma is a multiple of: 1, the variable, its range "
            "[default: absolute].",
        ),
    ] = None,
    population: Annotated[
        int | None, typer.Option(help="pymoo's algorithms: population size [default: 100].")
    ] = None,
    settings: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="NAME=VALUE",
            help="Any other parameter of the algorithm, such as bits=12 or restart=archive; may be "
            "given several times.",
        ),
    ] = None,
    evaluations: Annotated[
        int | None,
        typer.Option(
            min=1, help="Budget [default: 5000 generations of one candidate per variable]."
        ),
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of all randomness.")] = 1,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR", help="Folder to write [default: runs/PROBLEM-ALGORITHM-seedSEED]."
        ),
    ] = None,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Replace the run in an existing folder.")
    ] = False,
    record: Annotated[
        bool, typer.Option("--record", help="Keep every evaluation, in the folder's evaluations/.")
    ] = False,
    quiet: Quiet = False,
    debug: Debug = False,
) -> None:
    """Search the Pareto front of a problem and write it to a folder.

    The folder gets front.csv, run.json (how to run it again) and front.html. Ctrl-C ends the run
    and keeps what was found; a second one does so without waiting for the generation under way.
    A run of the MGEO family keeps itself in run.checkpoint while it goes on: see `mgeo resume`.
    """
    from mgeo.cli.parameters import parse_numbers, parse_settings, parse_value
    from mgeo.cli.solve import Request, run

    with one_line_errors(debug):
        given = {
            "sigma": parse_numbers("--sigma", sigma) if sigma is not None else None,
            "tau": parse_value(tau) if tau is not None else None,
            "n_runs": runs,
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
            quiet=quiet,
            debug=debug,
        )
    raise typer.Exit(run(request))


@app.command()
def resume(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Folder of the run.")],
    evaluations: Annotated[
        int | None,
        typer.Option(min=1, help="New budget, counted from the beginning of the run."),
    ] = None,
    generations: Annotated[
        int | None, typer.Option(min=1, help="New budget, in generations from the beginning.")
    ] = None,
    quiet: Quiet = False,
    debug: Debug = False,
) -> None:
    """Go on with a run that was interrupted or killed, or make a finished one longer.

    It goes on from run.checkpoint in the folder, exactly as the run would have done, and writes
    the same files.
    """
    from mgeo.cli.resume import run

    raise typer.Exit(
        run(folder, evaluations=evaluations, generations=generations, quiet=quiet, debug=debug)
    )


@app.command()
def report(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Folder of the run.")],
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="File to write [default: DIR/report.html].")
    ] = None,
    quiet: Quiet = False,
    debug: Debug = False,
) -> None:
    """Write one HTML file about a run, to be attached to a review.

    It shows what was run, the front and the plan of each of its points, and opens without a
    network.
    """
    from mgeo.cli.report import run

    run(folder, out=out, quiet=quiet, debug=debug)


@app.command()
def problems(debug: Debug = False) -> None:
    """List the installed problems."""
    from mgeo.cli.problems import list_problems

    with one_line_errors(debug):
        list_problems()


@app.command()
def study(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A study as TOML.")],
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
    quiet: Quiet = False,
    debug: Debug = False,
) -> None:
    """Compare algorithms as a file says, and write tables and figures.

    Finished runs are kept in the folder: a study that was interrupted goes on when the same
    command is given again.
    """
    from mgeo.cli.study import Request, run

    raise typer.Exit(run(Request(file, out, evaluations, seeds, jobs, cluster, quiet, debug)))
