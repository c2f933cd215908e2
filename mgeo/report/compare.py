"""Two runs, or two solutions in files of their problems, side by side as one HTML file."""

from __future__ import annotations

import json
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import zip_longest
from pathlib import Path
from typing import Any

import numpy as np
import plotly.graph_objects as go
from pymoo.core.problem import Problem

from mgeo.figures.front import axis
from mgeo.figures.page import drawing, render
from mgeo.figures.style import COLORS, SYMBOLS, finished, literal
from mgeo.plugins.protocol import column_names
from mgeo.plugins.shown import Review, Section, ask, cells, kinds_of
from mgeo.plugins.view import View, view_of
from mgeo.report.build import read_subject
from mgeo.runs.answer import default_solution
from mgeo.store.reading import read_json
from mgeo.store.run import Run
from mgeo.store.solution_file import solution_of
from mgeo.validation.entries import errors_of


@dataclass(frozen=True)
class Subject:
    """One of the two: a solution, what is said of it, and the run that it is of, if any."""

    name: str
    problem: Problem
    view: View
    review: Review
    options: Mapping[str, Any]
    run: Run | None = None
    solution: str = ""


def compare_html(one: Path | str, other: Path | str, *, named: Collection[str] = ()) -> str:
    """Two run folders or solutions' files side by side; of a run its default solution.

    Parameters
    ----------
    one, other
        That `mgeo solve` wrote, or JSON files of an installed problem with ``solution_of``.
    named
        Problems ``module:Class`` of which modules may be imported: no file has that done.

    Raises
    ------
    FileNotFoundError
        If there is nothing of that name, or a folder holds no run.
    ValueError, TypeError
        If a file is damaged, or is no solution of an installed problem.

    Examples
    --------
    >>> from mgeo.report import compare_html
    >>> page = compare_html("runs/first", "runs/second")  # doctest: +SKIP
    """
    names = distinct(Path(one), Path(other))
    both = zip((one, other), names, strict=True)
    subjects = [replace(read(Path(path), named), name=name) for path, name in both]
    front = fronts_figure(subjects)
    return render(
        "report/assets/compare.html",
        title=f"{names[0]} beside {names[1]}",
        names=names,
        cells=cells,
        kinds_of=kinds_of,
        glance=[["", *names], *_glance(subjects)],
        numbers=[["", *names, "second / first"], *_numbers(subjects)],
        options=[["option", *names], *_differences(*(subject.options for subject in subjects))],
        front=None if front is None else drawing(front),
        pairs=list(zip_longest(*(subject.review.sections for subject in subjects))),
        alike=_alike,
    )


def distinct(one: Path, other: Path) -> list[str]:
    """Names that tell two paths apart: their ends, from the last part on in which they differ."""
    ends = [path.resolve().parts for path in (one, other)]
    for k in range(1, max(map(len, ends)) + 1):
        names = [str(Path(*parts[-k:])) for parts in ends]
        if names[0] != names[1]:
            return names
    return [f"{one.name}, once", f"{one.name}, again"]


def read(path: Path, named: Collection[str] = ()) -> Subject:
    """A run folder's default solution, or that of a file which an installed problem knows.

    Raises
    ------
    FileNotFoundError, ValueError, TypeError
        See `compare_html`.
    """
    if path.is_dir():
        run, problem, _, _ = read_subject(path, named)
        row, label = 0, "nearest"
        if not len(run.outcome.F):
            raise ValueError(f"{path} holds no solution: expected a run that found one")
        if not run.outcome.nearest:
            shown = default_solution(problem, run.outcome.F)
            row, label = shown.row, shown.label
        view = view_of(problem, run.outcome.X, run.outcome.F).take([row])
        review, told = ask(view, View.review), run.configuration.options
        name = path.resolve().name
        return Subject(name, problem, view, review, told, run, f"{row}, {label}")
    if not path.exists():
        raise FileNotFoundError(f"there is neither a run folder nor a file {path}")
    document = read_json(path)
    with errors_of(path):
        problem, options, x = solution_of(document, named)
        view = view_of(problem, [x])
        return Subject(path.name, problem, view, ask(view, View.review), options)


def _glance(subjects: list[Subject]) -> Iterator[list[str]]:
    yield ["what it is", *(subject.review.title for subject in subjects)]
    yield ["answer", *(subject.review.answer for subject in subjects)]
    if any(subject.run for subject in subjects):
        told = [_run(subject) for subject in subjects]
        for key in dict.fromkeys(key for each in told for key in each):
            yield [key, *(each.get(key, "") for each in told)]


def _run(subject: Subject) -> dict[str, str]:
    run = subject.run
    if run is None:
        return {}
    volume = run.outcome.hypervolume
    return {
        "solution": subject.solution,
        "solutions": f"{len(run.outcome.F):,}",
        "algorithm": run.configuration.algorithm,
        "seed": str(run.configuration.seed),
        "evaluations": f"{run.outcome.evaluations:,}",
        "hypervolume": "" if volume is None else f"{volume:.4f}",
        "wall time": f"{run.outcome.wall_time_s:,.1f} s",
    }


def _numbers(subjects: list[Subject]) -> Iterator[list[str]]:
    """Numbers that both are described by."""
    first, second = (ask(subject.view, View.describe).iloc[0] for subject in subjects)
    for name in first.index.intersection(second.index, sort=False):
        a, b = first[name], second[name]
        if all(isinstance(value, int | float) for value in (a, b)):
            yield [str(name), f"{a:.5g}", f"{b:.5g}", f"{b / a:.3g}" if a else ""]


def _differences(one: Mapping[str, Any], other: Mapping[str, Any]) -> Iterator[list[str]]:
    """Options by their keys with dots, where they differ."""
    left, right = dict(_flat(one)), dict(_flat(other))
    for key in dict.fromkeys([*left, *right]):
        if left.get(key) != right.get(key):
            yield [key, left.get(key, "left out"), right.get(key, "left out")]


def _flat(node: Any, key: str = "") -> Iterator[tuple[str, str]]:
    if isinstance(node, Mapping):
        for name, value in node.items():
            yield from _flat(value, f"{key}.{name}" if key else str(name))
    elif isinstance(node, list) and any(isinstance(value, Mapping) for value in node):
        for i, value in enumerate(node):
            yield from _flat(value, f"{key}[{i}]")
    else:
        yield key, json.dumps(node, ensure_ascii=False)


def _alike(one: Section | None, other: Section | None) -> bool:
    """Whether sections of the two say the same."""
    if one is None or other is None:
        return False
    tables = [None if each.table is None else cells(each.table) for each in (one, other)]
    said = [(each.title, each.lines, each.note) for each in (one, other)]
    return said[0] == said[1] and tables[0] == tables[1]


def fronts_figure(subjects: list[Subject]) -> go.Figure | None:
    """Fronts, and what is compared, of two objectives of the same names, in one picture."""
    names = [column_names(subject.problem)[1] for subject in subjects]
    runs = any(subject.run for subject in subjects)
    if not runs or names[0] != names[1] or len(names[0]) != 2:
        return None
    figure = go.Figure()
    values = []
    for i, subject in enumerate(subjects):
        look = {"color": COLORS[i], "symbol": SYMBOLS[i], "size": 8, "opacity": 0.8}
        own = {"mode": "markers", "name": literal(subject.name), "legendgroup": str(i)}
        if subject.run is not None:
            x, y = subject.run.outcome.F.T
            figure.add_scatter(x=x, y=y, marker=look, **own)
            values.append(subject.run.outcome.F)
        x, y = subject.view.F.T
        ring = {"color": COLORS[i], "symbol": f"{SYMBOLS[i]}-open", "size": 16, "line_width": 3}
        figure.add_scatter(x=x, y=y, marker=ring, showlegend=subject.run is None, **own)
        values.append(subject.view.F)
    finished(figure, "", "")
    for k, update in enumerate((figure.update_xaxes, figure.update_yaxes)):
        update(axis(names[0][k], np.concatenate([value[:, k] for value in values])))
    return figure.update_layout(title=None, margin={"t": 40}, height=480)
