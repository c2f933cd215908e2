"""What there is to be solved, by what, and how algorithms compare."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import typer

from mgeo.cli import options
from mgeo.cli.errors import bad_input, of_interrupt
from mgeo.cli.output import Output


def problems(json: options.Json = False, debug: options.Debug = False) -> None:
    """List the installed problems."""
    from mgeo.cli.installed import list_problems

    list_problems(Output(json=json))


def algorithms(
    name: Annotated[
        str | None,
        typer.Argument(help="One of them, or MODULE:CLASS.", autocompletion=options.algorithms),
    ] = None,
    json: options.Json = False,
    debug: options.Debug = False,
) -> None:
    """List the algorithms, or the parameters of one."""
    from mgeo.cli.installed import list_algorithms

    with bad_input():
        list_algorithms(name, Output(json=json))


def study(
    file: Annotated[
        Path,
        typer.Argument(metavar="FILE", help="A study as TOML.", autocompletion=options.toml_files),
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


def schema(
    kind: Annotated[Literal["study"], typer.Argument(help="What the files are.")],
    debug: options.Debug = False,
) -> None:
    """Print a JSON Schema, by which editors complete and check files.

    In editors that know Taplo, a file names it in its first line: #:schema ./study.schema.json
    """
    from mgeo.studies.schema import study_schema

    typer.echo(study_schema())
