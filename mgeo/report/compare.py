"""HTML page that compares two runs, or two solutions in files."""

from __future__ import annotations

import json
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import zip_longest
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import plotly.graph_objects as go

from mgeo.figures.front import build_axis_layout
from mgeo.figures.page import render, render_figure
from mgeo.figures.style import COLORS, SYMBOLS, apply_style, escape_markup
from mgeo.plugins.protocol import call_optional, get_column_names
from mgeo.plugins.review import Review, format_cells
from mgeo.plugins.view import View, build_view
from mgeo.report.loaded_run import load_run
from mgeo.store.readers import read_json
from mgeo.store.run import Run
from mgeo.store.solution_file import parse_solution
from mgeo.validation.entries import convert_file_errors


@dataclass(frozen=True)
class ComparedSolution:
    """One of two solutions to be compared, with its review and the options of its problem.

    Attributes
    ----------
    name
        Name of the run folder or of the solution file.
    view
        View of the problem on this solution, see `mgeo.View`.
    review
        Review of the solution by its problem.
    options
        Options of the problem.
    run
        Run that found the solution; None for a solution file.
    solution
        Number and label of the solution in the run, such as "3, knee"; empty for a solution file.
    """

    name: str
    view: View
    review: Review
    options: Mapping[str, Any]
    run: Run | None = None
    solution: str = ""


def build_comparison_html(
    first: Path | str, second: Path | str, *, trusted_classes: Collection[str] = ()
) -> str:
    """Return an HTML page that compares two runs, or two solution files, side by side.

    A run is represented by its knee or, if there is none, by its default solution.

    Parameters
    ----------
    first, second
        Run folders of ``mgeo solve``, or JSON files that an installed problem can read (see
        ``parse_document`` in `mgeo.plugins`).
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
        If a path does not exist, or a folder contains no run.
    ValueError, TypeError
        If a file is damaged, or is not a solution of an installed problem.

    Examples
    --------
    >>> from mgeo.report import build_comparison_html
    >>> page = build_comparison_html("runs/first", "runs/second")  # doctest: +SKIP
    """
    paths = Path(first), Path(second)
    if paths[0].resolve() == paths[1].resolve():
        raise ValueError(f"{first} is given twice: expected two different runs or solutions")
    names = [path.resolve().name for path in paths]
    if names[0] == names[1]:
        names = [str(path) for path in paths]
    subjects = [
        replace(read_compared_solution(path, trusted_classes), name=name)
        for path, name in zip(paths, names, strict=True)
    ]
    front = draw_fronts(subjects)
    return render(
        "report/assets/compare.html",
        title=f"Comparison of {names[0]} and {names[1]}",
        names=names,
        quick_metrics=format_cells(_build_summary_table(subjects)),
        metrics=format_cells(_build_metrics_table(subjects)),
        options=format_cells(_build_options_table(subjects)),
        front=None if front is None else render_figure(front),
        section_pairs=list(zip_longest(*(subject.review.sections for subject in subjects))),
    )


def read_compared_solution(path: Path, trusted_classes: Collection[str] = ()) -> ComparedSolution:
    """Read a solution from a JSON file, or the default solution from a run folder.

    Parameters
    ----------
    path
        Run folder or solution file.
    trusted_classes
        See `build_comparison_html`.

    Raises
    ------
    FileNotFoundError, ValueError, TypeError
        See `build_comparison_html`.
    """
    if path.is_dir():
        loaded = load_run(path, trusted_classes)
        if loaded.default is None:
            raise ValueError(f"{path} contains no solution: expected a run that found one")
        view = loaded.view.select([loaded.default.row])
        solution = f"{loaded.default.row}, {loaded.default.label}"
        review, options = call_optional(view, View.review), loaded.run.configuration.options
        return ComparedSolution(path.name, view, review, options, loaded.run, solution)
    if not path.exists():
        raise FileNotFoundError(f"there is neither a run folder nor a file {path}")
    document = read_json(path)
    with convert_file_errors(path):
        problem, problem_options, x = parse_solution(document, trusted_classes)
        view = build_view(problem, [x])
        review = call_optional(view, View.review)
        return ComparedSolution(path.name, view, review, problem_options)


def _build_summary_table(subjects: Sequence[ComparedSolution]) -> pd.DataFrame:
    columns = {
        subject.name: {
            "title": subject.review.title,
            "summary": subject.review.summary,
            **_describe_run(subject),
        }
        for subject in subjects
    }
    return pd.DataFrame(columns).fillna("")


def _describe_run(subject: ComparedSolution) -> dict[str, str]:
    run = subject.run
    if run is None:
        return {}
    volume = run.outcome.hypervolume
    return {
        "solution": subject.solution,
        "solutions on the front": f"{len(run.outcome.F):,}",
        "algorithm": run.configuration.algorithm,
        "seed": str(run.configuration.seed),
        "evaluations": f"{run.outcome.n_evaluations:,}",
        "hypervolume": "" if volume is None else f"{volume:.4f}",
        "wall time": f"{run.outcome.wall_time_s:,.1f} s",
    }


def _build_metrics_table(subjects: Sequence[ComparedSolution]) -> pd.DataFrame:
    """Return a table of the numeric metrics of both solutions and the ratios between them."""
    descriptions = (call_optional(subject.view, View.describe) for subject in subjects)
    columns = [table.select_dtypes("number").iloc[0] for table in descriptions]
    table = pd.concat(columns, axis=1, join="inner", keys=[subject.name for subject in subjects])
    table = table.assign(**{"second / first": columns[1] / columns[0]})
    return table.rename(index=partial(_format_title, subjects))


def _format_title(subjects: Sequence[ComparedSolution], name: str) -> str:
    """Return the title of a column, or its name if the views of both solutions differ in it."""
    first, second = (subject.view.format_title(name) for subject in subjects)
    return first if first == second else name


def _build_options_table(subjects: Sequence[ComparedSolution]) -> pd.DataFrame:
    """Return a table of the problem options that differ between the solutions.

    The index contains the keys of the options; nested keys are joined by dots.
    """
    columns = {subject.name: dict(_flatten(subject.options)) for subject in subjects}
    table = pd.DataFrame(columns, dtype=object).rename_axis("option").fillna("not set")
    return table[table.nunique(axis=1) > 1]


def _flatten(node: Any, key: str = "") -> Iterator[tuple[str, str]]:
    if isinstance(node, Mapping):
        for name, value in node.items():
            yield from _flatten(value, f"{key}.{name}" if key else str(name))
    elif isinstance(node, list) and any(isinstance(value, Mapping) for value in node):
        for i, value in enumerate(node):
            yield from _flatten(value, f"{key}[{i}]")
    else:
        yield key, json.dumps(node, ensure_ascii=False)


def draw_fronts(subjects: list[ComparedSolution]) -> go.Figure | None:
    """Return a scatter plot of the fronts of both runs, with the compared solutions marked.

    Returns None unless both problems have the same two objectives and at least one of the compared
    solutions comes from a run.
    """
    names = [get_column_names(subject.view.problem)[1] for subject in subjects]
    has_run = any(subject.run for subject in subjects)
    if not has_run or names[0] != names[1] or len(names[0]) != 2:
        return None
    figure = go.Figure()
    objectives = []
    for i, subject in enumerate(subjects):
        marker = {"color": COLORS[i], "symbol": SYMBOLS[i], "size": 8, "opacity": 0.8}
        properties = {"mode": "markers", "name": escape_markup(subject.name), "legendgroup": str(i)}
        if subject.run is not None:
            x, y = subject.run.outcome.F.T
            figure.add_scatter(x=x, y=y, marker=marker, **properties)
            objectives.append(subject.run.outcome.F)
        x, y = subject.view.F.T
        ring = {"color": COLORS[i], "symbol": f"{SYMBOLS[i]}-open", "size": 16, "line_width": 3}
        figure.add_scatter(x=x, y=y, marker=ring, showlegend=subject.run is None, **properties)
        objectives.append(subject.view.F)
    apply_style(figure, "", "")
    for k, update in enumerate((figure.update_xaxes, figure.update_yaxes)):
        update(
            build_axis_layout(
                _format_title(subjects, names[0][k]), np.concatenate([F[:, k] for F in objectives])
            )
        )
    return figure.update_layout(title=None, margin={"t": 40}, height=480)
