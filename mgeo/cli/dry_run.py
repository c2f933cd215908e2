"""Output of ``--dry-run``: size of a run or study, and the files that it would write."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd

from mgeo.algorithms.base import ExtremalOptimization
from mgeo.cli.execution import format_run_title
from mgeo.figures.front import MAX_OBJECTIVES
from mgeo.plugins.protocol import call_optional, describe_size, has_override
from mgeo.plugins.review import Section
from mgeo.plugins.view import View, build_view
from mgeo.runs.prepare import PreparedRun
from mgeo.store import run_folder
from mgeo.terminal import Output

if TYPE_CHECKING:
    from pymoo.core.problem import Problem

    from mgeo.documents import DryRun, ProblemSize, StudyDryRun
    from mgeo.studies.study_file import Study


def print_run_size(run: PreparedRun, folder: Path, output: Output) -> None:
    """Print the problem size and budget of a run, and the files that the run would write.

    Parameters
    ----------
    run
        Prepared run.
    folder
        Folder that the run would write.
    output
        Destination of the text, or of the JSON document.
    """
    configuration, size, view = (
        run.configuration,
        describe_size(run.problem),
        build_view(run.problem),
    )
    files = [run_folder.FRONT_FILE, run_folder.ARRAYS_FILE, run_folder.RUN_FILE]
    if has_override(view, View.figures) or run.problem.n_obj <= MAX_OBJECTIVES:
        files.append(run_folder.FIGURE_FILE)
    if isinstance(run.algorithm, ExtremalOptimization):
        files.append(run_folder.CHECKPOINT_FILE)
    if run.record:
        files.append(f"{run_folder.RECORD_FOLDER}/")
    warnings, facts = call_optional(view, View.notes), call_optional(view, View.facts)
    search = f"{configuration.evaluations:,} evaluations"
    if configuration.initial_designs:
        search += f", {configuration.initial_designs} of them of suggested initial designs"
    if configuration.refine:
        search += "; then local refinement, which is not counted"
    texts = {"search": search, **_format_size(size, view), "folder": str(folder)}
    output.print_title(f"Dry run: {format_run_title(configuration)}")
    output.print_pairs(texts | {"files": ", ".join(files)})
    if facts:
        output.print("")
        output.print_pairs(facts)
    if warnings:
        output.print("")
        output.print_warnings(warnings)
    document: DryRun = {
        "dry_run": True,
        "configuration": configuration,
        "facts": dict(facts),
        "warnings": warnings,
        "folder": str(folder),
        "files": files,
    }
    output.print_document({**document, **size})


def print_study_size(
    study: Study, problems: Mapping[str, Problem], folder: Path, output: Output
) -> None:
    """Print the problem sizes, the algorithms and the total budget of a study.

    Parameters
    ----------
    study
        Study, as read from its file.
    problems
        Problems by label. Problems named ``module:Class`` are left out, because a dry run imports
        no modules that a file specifies.
    folder
        Folder that the study would write.
    output
        Destination of the text, or of the JSON document.
    """
    sizes = {label: describe_size(problem) for label, problem in problems.items()}
    algorithms = [algorithm.label for algorithm in study.algorithms]
    rows = [
        (label, len(size["variables"]), len(size["objectives"]), size["constraints"])
        for label, size in sizes.items()
    ]
    table = pd.DataFrame(rows, columns=["problem", "variables", "objectives", "constraints"])
    output.print_title(f"Dry run: {study.title}")
    output.print_text(study.format_size(), "")
    output.print_sections(Section("", table=table))
    output.print("")
    output.print_pairs({"algorithms": ", ".join(algorithms), "folder": str(folder)})
    document: StudyDryRun = {
        "dry_run": True,
        "title": study.title,
        "problems": sizes,
        "algorithms": algorithms,
        "evaluations": study.evaluations,
        "per_variable": study.per_variable,
        "n_runs": study.n_runs,
        "folder": str(folder),
    }
    output.print_document(document)


def _format_size(size: ProblemSize, view: View) -> dict[str, str]:
    return {
        "variables": str(len(size["variables"])),
        "objectives": ", ".join(map(view.format_title, size["objectives"])),
        "constraints": str(size["constraints"]),
    }
