"""Command ``mgeo study``."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, cast

import typer

from mgeo.cli import options
from mgeo.cli.errors import ExitCode, convert_input_errors, get_interrupt_exit_code
from mgeo.plugins.review import build_records
from mgeo.terminal import Output

if TYPE_CHECKING:
    from mgeo.documents import ProblemResults, Statistics, StudyDocument
    from mgeo.studies.comparison import Comparison
    from mgeo.studies.study_file import Study


_MAX_ROWS = 20  # maximum number of rows of a table on the terminal


def study(
    file: Annotated[
        Path,
        typer.Argument(
            metavar="FILE",
            help="Study file in TOML: problems, algorithms, seeds and number of evaluations.",
        ),
    ],
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR",
            rich_help_panel="Output",
            help="Folder to write [default: studies/NAME for NAME.toml].",
        ),
    ] = None,
    resume: Annotated[
        bool,
        typer.Option(
            "--resume",
            rich_help_panel="Output",
            help="Continue the interrupted study in the folder.",
        ),
    ] = False,
    evaluations: Annotated[
        int | None,
        typer.Option(
            min=1,
            metavar="N",
            rich_help_panel="Runs",
            help="Number of evaluations of each run [default: from FILE].",
        ),
    ] = None,
    seeds: Annotated[
        int | None,
        typer.Option(
            min=1,
            metavar="N",
            rich_help_panel="Runs",
            help="Number of seeds [default: from FILE].",
        ),
    ] = None,
    jobs: Annotated[
        int,
        typer.Option(
            metavar="N",
            rich_help_panel="Runs",
            help="Number of processes; -1 for one per processor.",
        ),
    ] = -1,
    cluster: Annotated[
        str | None,
        typer.Option(
            metavar="ADDRESS",
            rich_help_panel="Runs",
            help="Run on a Dask cluster, given the address of its scheduler.",
        ),
    ] = None,
    dry_run: options.DryRun = False,
    json: options.Json = False,
    quiet: options.Quiet = False,
    debug: options.Debug = False,
) -> None:
    """Compare algorithms on problems by statistical tests, and write a report.

    Each run is stored in the folder when it finishes, so that --resume can continue an interrupted
    study. The exit code is 3 if a run failed.
    """
    from mgeo.studies.comparison import ComparisonWarning
    from mgeo.studies.study import run_study
    from mgeo.studies.study_file import read_study

    folder, output = out or Path("studies", file.stem), Output(quiet, json)
    with convert_input_errors((ValueError, TypeError, OSError, BrokenProcessPool)):
        definition = read_study(file, allow_imports=not dry_run).with_budget(evaluations, seeds)
        if dry_run:
            from mgeo.cli.dry_run import print_study_size
            from mgeo.plugins.problems import is_class_path
            from mgeo.studies.plan import check_study_folder

            problems = {
                p.label: p.build() for p in definition.problems if not is_class_path(p.name)
            }
            check_study_folder(folder, definition.build_plan(), resume=resume)
            print_study_size(definition, problems, folder, output)
            labeled_names = [(p.label, p.name) for p in definition.problems]
            labeled_names += [(a.label, a.name) for a in definition.algorithms]
            for label, name in labeled_names:
                if is_class_path(name):
                    output.print_note(
                        f"Note: {label}: not checked, because a dry run imports no modules"
                    )
            return
        with _start_workers(jobs, cluster) as n_jobs, warnings.catch_warnings():
            warnings.simplefilter("ignore", ComparisonWarning)  # The warnings are printed as notes.
            try:
                comparisons = run_study(
                    definition, folder, resume=resume, n_jobs=n_jobs, progress=not quiet
                )
            except KeyboardInterrupt as error:
                output.print_note(f"interrupted; --resume continues with the runs in {folder}")
                raise typer.Exit(get_interrupt_exit_code(error)) from None
    raise typer.Exit(_print_results(definition, comparisons, folder, output))


def _print_results(
    study: Study, comparisons: dict[str, Comparison], folder: Path, output: Output
) -> int:
    """Print the conclusions and tables of a study, and return the exit code."""
    from mgeo.plugins.problems import format_problem_options
    from mgeo.store.run_folder import REPORT_FILE
    from mgeo.studies.conclusions import format_conclusions, list_warnings, summarize_study
    from mgeo.studies.summary_tables import (
        build_behind_table,
        build_published_table,
        build_rank_table,
        build_result_table,
    )

    summary = summarize_study(comparisons, study.control)
    warnings = list_warnings(comparisons, study.control)
    document: StudyDocument = {
        "title": study.title,
        "folder": str(folder),
        "report": str(folder / REPORT_FILE),
        "evaluations": study.evaluations,
        "per_variable": study.per_variable,
        "seeds": list(study.seeds),
        "conclusions": [] if summary is None else summary.conclusions,
        "warnings": warnings,
        "ranks": [] if summary is None else build_records(summary.ranks),
        "problems": {
            label: _build_document(each, study.control) for label, each in comparisons.items()
        },
    }
    output.print_document(document)
    output.print_title(f"Study: {study.title}")
    output.print_text(study.format_size(), "")
    if len(comparisons) > 1 and summary is not None:
        output.print_text(*summary.conclusions)
        tables = [build_rank_table(comparisons, summary), build_behind_table(summary)]
    else:
        (comparison,) = comparisons.values()
        output.print_text(*format_conclusions(comparison, study.control))
        tables = [
            build_result_table(comparison),
            build_published_table(study, comparison),
        ]
    for section in tables:
        if section is not None:
            output.print("")
            output.print_sections(replace(section, max_rows=_MAX_ROWS))
    if warnings:
        output.print("")
        output.print_warnings(warnings)
    output.print_files({str(folder / REPORT_FILE): "report"})
    figure = "ranks" if len(comparisons) > 1 else "anytime"
    imports = format_problem_options(p.name for p in study.problems)
    command = f"mgeo report {folder} --figure {figure} --paper{imports}"
    commands = {"Draw a figure for a paper": command}
    if find_spec("kaleido") is None:
        commands = {"Install the export of figures": "pip install 'mgeo[png]'"} | commands
    output.print_commands(commands)
    n_failed = sum(_count_runs(each, "failed") for each in comparisons.values())
    if n_failed:
        output.print_note(f"{n_failed} runs failed; --resume repeats them")
    return ExitCode.INCOMPLETE if n_failed else ExitCode.SUCCESS


@contextmanager
def _start_workers(jobs: int, cluster: str | None) -> Iterator[int | None]:
    """Context manager that yields the number of processes, or None for a Dask cluster."""
    if jobs == 0:
        raise ValueError("--jobs 0: expected a number of processes, or -1 for one per processor")
    if cluster is None:
        yield jobs
        return
    try:
        from distributed import Client
    except ImportError as error:
        raise ValueError("--cluster requires Dask: pip install 'mgeo[distributed]'") from error
    import joblib

    try:
        client = Client(cluster)
    except (OSError, ValueError) as error:
        raise ValueError(f"--cluster {cluster}: {error}") from error
    with client, joblib.parallel_config("dask"):
        yield None


def _build_document(comparison: Comparison, control: str | None) -> ProblemResults:
    from mgeo.studies.conclusions import format_conclusions

    summary = comparison.summarize()
    names = [name for name in dict.fromkeys(summary.columns.get_level_values(0)) if name != "runs"]
    return {
        "n_finished": _count_runs(comparison, "finished"),
        "n_failed": _count_runs(comparison, "failed"),
        "conclusions": format_conclusions(comparison, control),
        "ranking": comparison.rank_algorithms(),
        "algorithms": {
            label: {
                name: cast("Statistics", summary.loc[label, name].astype(float).to_dict())
                for name in names
            }
            for label in comparison.algorithms
        },
    }


def _count_runs(comparison: Comparison, status: str) -> int:
    return int((comparison.runs["status"] == status).sum())
