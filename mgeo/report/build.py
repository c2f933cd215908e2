"""HTML report of a run folder as one file, which loads nothing from the network.

The report of a recorded run shows the hypervolume over evaluations. The report also shows Monte
Carlo results from files ``verification*.json``, which the tools of a problem write into the run
folder. Each file is a JSON object with these keys:

``title``, ``conclusion``
    Texts.
``columns``, ``rows``
    Column titles, as a list of strings, and rows, as lists of numbers or strings of equal length.
``problem``, ``options``, ``design``
    Verified solution: the name and options of the problem, and the variables in a row of
    ``front.csv``.

A file is ignored if its solution is not on the front of the run, for example after a new run.
"""

from __future__ import annotations

import json
from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from typing import Any

import pandas as pd
from markupsafe import Markup
from plotly.offline import get_plotlyjs
from pymoo.core.problem import Problem

from mgeo._text import format_key_title, format_number
from mgeo.figures.page import render
from mgeo.plugins import protocol
from mgeo.plugins.protocol import call_optional, has_override
from mgeo.plugins.review import format_cells
from mgeo.plugins.view import View
from mgeo.report.history import draw_hypervolume_history
from mgeo.report.loaded_run import load_run
from mgeo.report.solutions import Json, build_figure_json, build_solutions_json, format_script_json
from mgeo.runs.summary import explain_infeasibility
from mgeo.store.readers import read_json
from mgeo.store.run import Run
from mgeo.store.run_folder import VERIFICATION_FILES, check_verification
from mgeo.validation.entries import convert_file_errors


def format_verification_tables(
    verification: Mapping[str, Any],
) -> Iterator[tuple[str, list[list[str]]]]:
    """Format each table in a verification file as a title and rows of strings.

    A table is a list of objects with equal keys, from which the column titles in the first row are
    made. The keys ``bound_type`` and ``bound_value`` become one column. Empty columns are omitted.

    Parameters
    ----------
    verification
        Content of the verification file.
    """
    for key, rows in verification.items():
        if not (isinstance(rows, list) and rows and all(isinstance(row, dict) for row in rows)):
            continue
        titles = list(rows[0])
        if all(list(row) == titles for row in rows):
            table = pd.DataFrame(rows, columns=titles)
            if {"bound_type", "bound_value"} <= set(titles):
                bounds = table.pop("bound_type") + table.pop("bound_value").map(
                    " {:.4g}".format, na_action="ignore"
                )
                table["bound"] = bounds
            table = table.dropna(axis="columns", how="all").rename(columns=format_key_title)
            yield key.replace("_", " ").capitalize(), format_cells(table)


def read_verifications(
    folder: Path, run: Run, problem: Problem
) -> Iterator[tuple[str, str, Mapping[str, Any]]]:
    """Read the verification files of a run.

    Yield the name of each file, a reason to ignore it, and its content.

    The reason is an empty string if the file verifies a solution on the front of the run.

    Parameters
    ----------
    folder
        Run folder.
    run
        Run of the folder.
    problem
        Problem of the run.

    Raises
    ------
    ValueError, TypeError
        If a file has invalid content.
    """
    options = protocol.get_options(problem)
    if options is None:
        options = run.configuration.options
    expected = {"problem": run.configuration.problem, "options": json.loads(json.dumps(options))}
    designs = (run.outcome.nearest or run.outcome).X.tolist()
    for path in sorted(folder.glob(VERIFICATION_FILES)):
        document = read_json(path)
        with convert_file_errors(path):
            check_verification(document)
        reason = ""
        if {key: document.get(key) for key in expected} != expected:
            reason = "its problem or its options differ from those of this run"
        elif document.get("design") not in designs:
            reason = "its design is not a solution of this front"
        yield path.name, reason, document


def build_report_html(
    folder: Path | str, solution: int | None = None, *, trusted_classes: Collection[str] = ()
) -> str:
    """Return the report of a run folder as one HTML page.

    Parameters
    ----------
    folder
        Run folder of ``mgeo solve``.
    solution
        Number of the solution to review, which the page shows first. Default: the knee.
    trusted_classes
        Problem classes, as ``module:Class``, whose modules may be imported. Other modules that a
        file specifies are not imported.

    Returns
    -------
    str
        HTML page, which loads nothing from the network.

    Raises
    ------
    FileNotFoundError
        If the folder contains no run.
    ValueError, TypeError
        If a file is damaged, the options of the problem are invalid, or the number of the solution
        is out of range.

    Examples
    --------
    >>> from mgeo.report import build_report_html
    >>> page = build_report_html("runs/first")  # doctest: +SKIP
    """
    folder = Path(folder)
    loaded = load_run(folder, trusted_classes)
    run, view, default = loaded.run, loaded.view, loaded.default
    n, is_feasible = len(view.X), default is not None and not run.outcome.nearest
    if solution is not None and not 0 <= solution < n:
        raise ValueError(f"solution {solution}: expected 0 to {n - 1}")
    data: Json = {"table": None, "noun": view.noun}
    heading, summary, review = "", "", None
    if default is not None:
        row = default.row if solution is None else solution
        data |= build_solutions_json(loaded) | {"first": row}
        selected = view.select([row])
        if has_override(view, View.review):
            review = call_optional(selected, View.review)
        if is_feasible:
            heading = f"{view.noun.capitalize()} {row}"
            if solution is None:
                heading = f"Recommended {view.noun}: number {row}, {default.label}"
            (summary,) = call_optional(selected, View.summaries)
            summary = review.summary if review else summary
    # The warnings of the run include those of the solution.
    sections = (
        [section for section in review.sections if section.key != "warnings"] if review else []
    )
    history = draw_hypervolume_history(folder, loaded.problem, run.outcome)
    data["history"] = None if history is None else build_figure_json(history)
    return render(
        "report/assets/report.html",
        title=loaded.title,
        review=review,
        review_sections=(
            [section for section in sections if not section.is_detail],
            [section for section in sections if section.is_detail],
        ),
        noun=view.noun,
        format_title=view.format_title,
        heading=heading,
        summary=summary,
        warnings=call_optional(view, View.warnings) if is_feasible else [],
        infeasibility=(
            explain_infeasibility(view, run.outcome.n_evaluations) if run.outcome.nearest else None
        ),
        folder=folder.resolve().name,
        run=run,
        configuration=run.configuration,
        outcome=run.outcome,
        X=view.X.tolist(),
        F=view.F.tolist(),
        options=json.dumps(run.configuration.options, indent=2, ensure_ascii=False),
        representatives=loaded.representatives,
        format_number=format_number,
        format_verification_tables=format_verification_tables,
        verifications=list(read_verifications(folder, run, loaded.problem)),
        data=data,
        json=Markup(format_script_json(data)),
        library=Markup(get_plotlyjs()),
    )
