"""The commands; each imports what it needs only when it is run."""

from __future__ import annotations

import os
import textwrap
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Literal

import typer

from mgeo.cli import completion, new, options
from mgeo.cli.commands import RootCommands
from mgeo.cli.errors import ExitCode, bad_input, of_interrupt
from mgeo.cli.examples import epilog
from mgeo.cli.output import Output


def _exit_codes() -> Iterator[str]:
    for code in ExitCode:
        lines = textwrap.wrap(code.meaning, 66)
        yield from (
            f"{c:>5}  {line}" for c, line in zip([code.value, *[""] * 9], lines, strict=False)
        )


app = typer.Typer(
    name="mgeo",
    cls=RootCommands,
    help="Multiobjective generalized extremal optimization of installed problems.",
    epilog="\n".join(["\b", "Exit codes:", *_exit_codes()]),
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["--help", "-h"]},
)
app.add_typer(new.app, name="new")


def main() -> None:
    """Entry point of the command ``mgeo``."""
    app()


def _print_version(wanted: bool) -> None:
    if wanted:
        from mgeo.cli.versions import versions

        for name, number in versions().items():
            typer.echo(f"{name} {number}")
        raise typer.Exit


@app.callback()
def _root(
    show_version: Annotated[
        bool,
        typer.Option(
            "--version",
            callback=_print_version,
            is_eager=True,
            help="Print the versions of mgeo, its plugins and what they need, and exit.",
        ),
    ] = False,
    no_color: Annotated[
        bool, typer.Option("--no-color", help="No colors, as with NO_COLOR in the environment.")
    ] = False,
) -> None:
    if no_color:
        os.environ["NO_COLOR"] = "1"


@app.command(epilog=epilog("solve"))
def solve(
    problem: Annotated[
        str,
        typer.Argument(
            help="One of `mgeo problems`, a class of one's own, module:Class, or a test problem, "
            "pymoo:zdt1.",
            autocompletion=completion.problems,
        ),
    ],
    scenario: Annotated[
        str | None,
        typer.Option(
            metavar="FILE.toml|PRESET",
            help="Options of the problem: a file, or a preset's name.",
            autocompletion=completion.scenarios,
        ),
    ] = None,
    after: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.json",
            help="Go on from a result, such as a calibration, if the problem can; a scenario file "
            "says only what differs.",
        ),
    ] = None,
    robust: Annotated[
        bool,
        typer.Option(
            "--robust",
            help="Judge solutions by what they keep where things are not exactly known, if the "
            "problem can.",
        ),
    ] = False,
    algorithm: Annotated[
        str | None,
        typer.Option(
            metavar="NAME|MODULE:CLASS",
            help="One of `mgeo algorithms`, or a class of one's own [default: mgeo-directed, of a "
            "robust run mgeo-staged].",
            autocompletion=completion.algorithms,
        ),
    ] = None,
    sigma: options.Sigma = None,
    tau: options.Tau = None,
    walkers: options.Walkers = None,
    perturbation: options.Perturbation = None,
    population: options.Population = None,
    settings: options.Settings = None,
    evaluations: Annotated[
        int | None,
        typer.Option(
            min=1, help="Budget [default: 5000 generations of one candidate per variable]."
        ),
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of all randomness.")] = 1,
    starts: Annotated[
        int | None,
        typer.Option(
            min=0,
            help="Designs that the problem suggests, to begin with [default: what the problem "
            "recommends; 0 with --robust, --evaluations, an algorithm or its parameters].",
        ),
    ] = None,
    polish: Annotated[
        bool | None,
        typer.Option(
            "--polish/--no-polish",
            help="Let the problem refine what was found, in addition to the budget [default: as "
            "for --starts].",
        ),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR",
            help="Folder to write [default: runs/PROBLEM-ALGORITHM-seedSEED, of a robust run "
            "runs/PROBLEM-robust-ALGORITHM-seedSEED].",
        ),
    ] = None,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Replace the run in an existing folder.")
    ] = False,
    record: Annotated[
        bool, typer.Option("--record", help="Save every evaluation, in the folder's evaluations/.")
    ] = False,
    dry_run: options.DryRun = False,
    json: options.Json = False,
    quiet: options.Quiet = False,
    verbose: options.Verbose = False,
    debug: options.Debug = False,
) -> None:
    """Search the Pareto front of a problem and write it to a folder.

    The folder gets front.csv, run.json (how to run it again) and front.html. Ctrl-C ends the run
    and keeps what was found; a second one does so without waiting for the generation under way.
    A run of the MGEO family saves itself in run.checkpoint while it goes on: see `mgeo resume`.
    What an algorithm takes, and its defaults: `mgeo algorithms NAME`.
    """
    from mgeo.algorithms.staged import has_stages
    from mgeo.runs.algorithms import ROBUST, default_algorithm
    from mgeo.runs.prepare import prepare, read_scenario
    from mgeo.store.run_folder import check_folder
    from mgeo.store.run_persistence import RunPersistence

    given, algorithm = algorithm, algorithm or default_algorithm(robust)
    # of a collection, coco:bbob/f1/d10/i1, and of a class, module:Class
    name = f"{problem}{'-robust' if robust else ''}-{algorithm}".replace(":", "-").replace("/", "-")
    folder = out or Path("runs", f"{name}-seed{seed}")
    flags = {
        "sigma": sigma,
        "tau": tau,
        "n_walkers": walkers,
        "perturbation": perturbation,
        "population": population,
    }
    with bad_input():
        run = prepare(
            problem,
            parameters=options.parse_parameters(algorithm, flags, settings or []),
            options=read_scenario(problem, scenario, after=after, named=(problem,)),
            algorithm=given,
            evaluations=evaluations,
            seed=seed,
            robust=robust,
            starts=starts,
            polish=polish,
        )
        persistence = RunPersistence(folder, run.configuration, run.algorithm, record=record)
        check_folder(folder, overwrite=overwrite)
    output = Output(quiet, json)
    if not robust and algorithm != ROBUST and has_stages(run.problem):
        output.note(
            f"Note: the problem can be judged by stages, which {ROBUST} does and {algorithm} does "
            "not; that takes less time"
        )
    if dry_run:
        from mgeo.cli.dry_run import describe_run

        describe_run(run, persistence, output)
    else:
        from mgeo.cli.solve import run_to_folder

        raise typer.Exit(
            run_to_folder(run, persistence, output, overwrite=overwrite, verbose=verbose)
        )


@app.command(epilog=epilog("resume"))
def resume(
    folder: Annotated[
        Path,
        typer.Argument(
            metavar="DIR",
            help="Folder of the run.",
            autocompletion=completion.runs_with("run.checkpoint"),
        ),
    ],
    evaluations: Annotated[
        int | None,
        typer.Option(min=1, help="New budget, counted from the beginning of the run."),
    ] = None,
    generations: Annotated[
        int | None, typer.Option(min=1, help="New budget, in generations from the beginning.")
    ] = None,
    algorithm: Annotated[
        str | None,
        typer.Option(
            metavar="MODULE:CLASS",
            help="That of the run, where it is none by name: no file has a module imported.",
        ),
    ] = None,
    problem: options.Problem = None,
    check: Annotated[
        bool,
        typer.Option(
            "--check/--no-check",
            help="Evaluate a few points again first, and refuse a problem that has changed.",
        ),
    ] = True,
    json: options.Json = False,
    quiet: options.Quiet = False,
    verbose: options.Verbose = False,
    debug: options.Debug = False,
) -> None:
    """Go on with a run that was interrupted or killed, or make a finished one longer.

    It goes on from run.checkpoint in the folder, exactly as the run would have done, and writes
    the same files.
    """
    from mgeo.cli.solve import resumed, run_to_folder

    output = Output(quiet, json)
    with bad_input():
        if evaluations is not None and generations is not None:
            raise ValueError("--evaluations and --generations are both given: expected one")
        run, persistence = resumed(
            folder,
            output,
            evaluations=evaluations,
            generations=generations,
            algorithm=algorithm,
            problem=problem,
            check=check,
        )
    raise typer.Exit(run_to_folder(run, persistence, output, overwrite=True, verbose=verbose))


@app.command(epilog=epilog("report"))
def report(
    sources: Annotated[
        list[Path],
        typer.Argument(
            metavar="DIR [DIR]",
            help="Folder of a run, or of a study; two runs, or two solutions' files, are set side "
            "by side.",
            autocompletion=completion.runs_with("run.json"),
        ),
    ],
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE", help="File to write [default: DIR/report.html, of two comparison.html]."
        ),
    ] = None,
    solution: Annotated[
        int | None,
        typer.Option(metavar="N", min=0, help="Solution to be reviewed [default: the knee]."),
    ] = None,
    png: Annotated[
        bool, typer.Option("--png", help="Also write the figures as PNG, into figures beside FILE.")
    ] = False,
    pdf: Annotated[
        bool, typer.Option("--pdf", help="Also write the figures as PDF, into figures beside FILE.")
    ] = False,
    figure: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME",
            help="Write only this figure, such as front, knee-rates or ranks, as PNG unless --pdf "
            "is given; may be given several times. No report is written.",
        ),
    ] = None,
    paper: Annotated[
        bool,
        typer.Option(
            "--paper", help="Figures for a paper: 88 mm wide, 8-point serif, no title, as PDF."
        ),
    ] = False,
    problem: options.Problem = None,
    json: options.Json = False,
    quiet: options.Quiet = False,
    debug: options.Debug = False,
) -> None:
    """Write one HTML file about a run, to be attached to a review.

    It shows what was run, the front and the plan of each of its points, and opens without a
    network. Printed, it is a document for a review of one solution. Pictures are of the front, the
    hypervolume, and the knee and the best solutions; they need kaleido (pip install 'mgeo[png]')
    and Chrome or Chromium. A study has its report already: of it only figures are written, and
    without an option their names are told.
    """
    from mgeo.cli.report import is_study, write_comparison, write_report, write_study_figures

    output = Output(quiet, json)
    if len(sources) > 1:
        with bad_input():
            if len(sources) > 2:
                raise ValueError(f"{len(sources)} runs: expected one, or two to be compared")
            if png or pdf or figure or paper or solution is not None:
                raise ValueError("of two runs there is a page only: expected no other options")
        write_comparison(sources[0], sources[1], out, output)
        return
    formats = [kind for kind, wanted in (("png", png), ("pdf", pdf or paper)) if wanted]
    if figure and not formats:
        formats = ["png"]
    (folder,) = sources
    only = figure or ()
    if is_study(folder):
        with bad_input():
            if out is not None or solution is not None:
                raise ValueError("of a study there are figures only: expected no --out, --solution")
        write_study_figures(folder, formats, output, only=only, paper=paper, problem=problem)
    else:
        write_report(
            folder,
            out,
            formats,
            output,
            only=only,
            paper=paper,
            solution=solution,
            problem=problem,
        )


@app.command(epilog=epilog("explore"))
def explore(
    folder: Annotated[
        Path,
        typer.Argument(
            metavar="DIR",
            help="Folder of a run.",
            autocompletion=completion.runs_with("run.json"),
        ),
    ],
    save: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR|FILE.json",
            help="Where the page may write solutions: into a folder, or only this file "
            "[default: DIR].",
        ),
    ] = None,
    port: Annotated[
        int, typer.Option(min=0, max=65535, help="Port on 127.0.0.1; 0 for any that is free.")
    ] = 0,
    browser: Annotated[
        bool, typer.Option("--browser/--no-browser", help="Open the page in the browser.")
    ] = True,
    problem: options.Problem = None,
    json: options.Json = False,
    quiet: options.Quiet = False,
    debug: options.Debug = False,
) -> None:
    """Explore a run on a page: filter, choose and change solutions, and save them.

    Changed variables are evaluated while a slider moves. The page is served to this machine alone,
    under an address that nobody can guess, until Ctrl-C.
    """
    from mgeo.cli.explore import serve

    serve(folder, Output(quiet, json), save=save, port=port, browser=browser, problem=problem)


@app.command(epilog=epilog("problems"))
def problems(json: options.Json = False, debug: options.Debug = False) -> None:
    """List the installed problems."""
    from mgeo.cli.installed import list_problems

    list_problems(Output(json=json))


@app.command(epilog=epilog("algorithms"))
def algorithms(
    name: Annotated[
        str | None,
        typer.Argument(help="One of them, or MODULE:CLASS.", autocompletion=completion.algorithms),
    ] = None,
    json: options.Json = False,
    debug: options.Debug = False,
) -> None:
    """List the algorithms, or the parameters of one."""
    from mgeo.cli.installed import list_algorithms

    with bad_input():
        list_algorithms(name, Output(json=json))


@app.command(epilog=epilog("study"))
def study(
    file: Annotated[
        Path,
        typer.Argument(
            metavar="FILE", help="A study as TOML.", autocompletion=completion.toml_files
        ),
    ],
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
    coco_data: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR", help="Log all runs by COCO's observer there, for cocopp to read."
        ),
    ] = None,
    dry_run: options.DryRun = False,
    json: options.Json = False,
    quiet: options.Quiet = False,
    debug: options.Debug = False,
) -> None:
    """Compare algorithms as a file says, and write tables and figures.

    Finished runs are saved in the folder: a study that was interrupted goes on when the same
    command is given again.
    """
    from mgeo.cli.dry_run import describe_study
    from mgeo.cli.study import notes, show, workers
    from mgeo.studies.file import read_study
    from mgeo.studies.study import estimate_study, run_study

    folder, output = out or Path("studies", file.stem), Output(quiet, json)
    with bad_input(), notes(output):
        if coco_data and cluster:
            raise ValueError("--coco-data: expected no --cluster, whose workers write elsewhere")
        read = read_study(file, imports=not dry_run).reduced(evaluations, seeds)
        with workers(jobs, cluster) as n_jobs:
            if dry_run:
                expected = estimate_study(read, folder, n_jobs=n_jobs)
                describe_study(read, expected, folder, output)
                return
            try:
                comparisons = run_study(
                    read, folder, n_jobs=n_jobs, progress=not quiet, coco_data=coco_data
                )
            except KeyboardInterrupt as error:
                output.note(f"interrupted; the same command goes on with what is in {folder}")
                raise typer.Exit(of_interrupt(error)) from None
    raise typer.Exit(show(read, comparisons, folder, output))


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
