"""HTML page that compares two runs, or two solutions in files of their problems."""

from __future__ import annotations

import json
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
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
from mgeo.plugins.review import Review, find_column_kinds, format_cells
from mgeo.plugins.view import View, build_view
from mgeo.report.loaded_run import load_run
from mgeo.store.readers import read_json
from mgeo.store.run import Run
from mgeo.store.solution_file import parse_solution
from mgeo.validation.entries import convert_file_errors


@dataclass(frozen=True)
class ComparedSolution:
    """One of the two compared solutions, with its review and the options of its problem.

    Attributes
    ----------
    name : name of the run folder or file.
    view : view of the solution.
    review : review of the solution by its problem.
    options : options of the problem.
    run : run that found the solution, None for a solution file.
    solution : number and label of the solution in the run.
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
    """Return an HTML page that compares two run folders or solution files.

    The default solution represents a run.

    Parameters
    ----------
    first, second
        Run folders of ``mgeo solve``, or JSON files of an installed problem with ``solution_of``.
    trusted_classes
        Problems ``module:Class`` whose modules may be imported; no other modules are imported on
        behalf of a file.

    Raises
    ------
    FileNotFoundError
        If a path does not exist, or a folder holds no run.
    ValueError, TypeError
        If a file is damaged, or is not a solution of an installed problem.

    Examples
    --------
    >>> from mgeo.report import build_comparison_html
    >>> page = build_comparison_html("runs/first", "runs/second")  # doctest: +SKIP
    """
    paths = Path(first), Path(second)
    if paths[0].resolve() == paths[1].resolve():
        raise ValueError(f"{first} is given twice: expected two runs or solutions")
    names = [path.resolve().name for path in paths]
    if names[0] == names[1]:
        names = [str(path) for path in paths]
    both = zip(paths, names, strict=True)
    subjects = [
        replace(read_compared_solution(path, trusted_classes), name=name) for path, name in both
    ]
    front = draw_fronts(subjects)
    return render(
        "report/assets/compare.html",
        title=f"Comparison of {names[0]} and {names[1]}",
        names=names,
        format_cells=format_cells,
        find_column_kinds=find_column_kinds,
        quick_metrics=format_cells(_build_summary_table(subjects)),
        metrics=format_cells(_build_metrics_table(subjects), digits=5),
        options=format_cells(_build_options_table(subjects)),
        front=None if front is None else render_figure(front),
        section_pairs=list(zip_longest(*(subject.review.sections for subject in subjects))),
    )


def read_compared_solution(path: Path, trusted_classes: Collection[str] = ()) -> ComparedSolution:
    """Read the default solution of a run folder, or the solution of a file.

    Raises
    ------
    FileNotFoundError, ValueError, TypeError
        See `build_comparison_html`.
    """
    if path.is_dir():
        shown = load_run(path, trusted_classes)
        if shown.default is None:
            raise ValueError(f"{path} holds no solution: expected a run that found one")
        view = shown.view.select([shown.default.row])
        solution = f"{shown.default.row}, {shown.default.label}"
        review, options = call_optional(view, View.review), shown.run.configuration.options
        return ComparedSolution(path.name, view, review, options, shown.run, solution)
    if not path.exists():
        raise FileNotFoundError(f"there is neither a run folder nor a file {path}")
    document = read_json(path)
    with convert_file_errors(path):
        problem, own_options, x = parse_solution(document, trusted_classes)
        view = build_view(problem, [x])
        return ComparedSolution(path.name, view, call_optional(view, View.review), own_options)


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
        "solutions": f"{len(run.outcome.F):,}",
        "algorithm": run.configuration.algorithm,
        "seed": str(run.configuration.seed),
        "evaluations": f"{run.outcome.n_evaluations:,}",
        "hypervolume": "" if volume is None else f"{volume:.4f}",
        "wall time": f"{run.outcome.wall_time_s:,.1f} s",
    }


def _build_metrics_table(subjects: Sequence[ComparedSolution]) -> pd.DataFrame:
    """Return the metrics that describe both solutions, and their ratios."""
    described = (call_optional(subject.view, View.describe) for subject in subjects)
    columns = [table.select_dtypes("number").iloc[0] for table in described]
    table = pd.concat(columns, axis=1, join="inner", keys=[subject.name for subject in subjects])
    return table.assign(**{"second / first": columns[1] / columns[0]})


def _build_options_table(subjects: Sequence[ComparedSolution]) -> pd.DataFrame:
    """Return the options that differ, by dotted keys."""
    columns = {subject.name: dict(_flatten(subject.options)) for subject in subjects}
    table = pd.DataFrame(columns, dtype=object).rename_axis("option").fillna("left out")
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
    """Draw the fronts of both subjects and the compared solutions in one figure.

    Returns None unless both problems have the same two objectives and a subject is a run.
    """
    names = [get_column_names(subject.view.problem)[1] for subject in subjects]
    runs = any(subject.run for subject in subjects)
    if not runs or names[0] != names[1] or len(names[0]) != 2:
        return None
    figure = go.Figure()
    values = []
    for i, subject in enumerate(subjects):
        look = {"color": COLORS[i], "symbol": SYMBOLS[i], "size": 8, "opacity": 0.8}
        properties = {"mode": "markers", "name": escape_markup(subject.name), "legendgroup": str(i)}
        if subject.run is not None:
            x, y = subject.run.outcome.F.T
            figure.add_scatter(x=x, y=y, marker=look, **properties)
            values.append(subject.run.outcome.F)
        x, y = subject.view.F.T
        ring = {"color": COLORS[i], "symbol": f"{SYMBOLS[i]}-open", "size": 16, "line_width": 3}
        figure.add_scatter(x=x, y=y, marker=ring, showlegend=subject.run is None, **properties)
        values.append(subject.view.F)
    apply_style(figure, "", "")
    for k, update in enumerate((figure.update_xaxes, figure.update_yaxes)):
        update(build_axis_layout(names[0][k], np.concatenate([value[:, k] for value in values])))
    return figure.update_layout(title=None, margin={"t": 40}, height=480)
