"""Two runs, or two solutions in files of their problems, side by side as one HTML file."""

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

from mgeo.figures.front import axis
from mgeo.figures.page import drawing, render
from mgeo.figures.style import COLORS, SYMBOLS, finished, literal
from mgeo.plugins.protocol import ask, column_names
from mgeo.plugins.shown import Review, cells, kinds_of
from mgeo.plugins.view import View, view_of
from mgeo.report.shown_run import read_shown_run
from mgeo.store.reading import read_json
from mgeo.store.run import Run
from mgeo.store.solution_file import solution_of
from mgeo.validation.entries import errors_of


@dataclass(frozen=True)
class Subject:
    """A solution, its review, the options of its problem, and the run that found it, if any."""

    name: str
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
    paths = Path(one), Path(other)
    if paths[0].resolve() == paths[1].resolve():
        raise ValueError(f"{one} is given twice: expected two runs or solutions")
    names = [path.resolve().name for path in paths]
    if names[0] == names[1]:
        names = [str(path) for path in paths]
    both = zip(paths, names, strict=True)
    subjects = [replace(read(path, named), name=name) for path, name in both]
    front = fronts_figure(subjects)
    return render(
        "report/assets/compare.html",
        title=f"{names[0]} beside {names[1]}",
        names=names,
        cells=cells,
        kinds_of=kinds_of,
        glance=cells(_glance(subjects)),
        numbers=cells(_numbers(subjects), digits=5),
        options=cells(_differences(subjects)),
        front=None if front is None else drawing(front),
        pairs=list(zip_longest(*(subject.review.sections for subject in subjects))),
    )


def read(path: Path, named: Collection[str] = ()) -> Subject:
    """A run folder's default solution, or that of a file which an installed problem knows.

    Raises
    ------
    FileNotFoundError, ValueError, TypeError
        See `compare_html`.
    """
    if path.is_dir():
        shown = read_shown_run(path, named)
        if shown.default is None:
            raise ValueError(f"{path} holds no solution: expected a run that found one")
        view = shown.view.take([shown.default.row])
        solution = f"{shown.default.row}, {shown.default.label}"
        review, told = ask(view, View.review), shown.run.configuration.options
        return Subject(path.name, view, review, told, shown.run, solution)
    if not path.exists():
        raise FileNotFoundError(f"there is neither a run folder nor a file {path}")
    document = read_json(path)
    with errors_of(path):
        problem, options, x = solution_of(document, named)
        view = view_of(problem, [x])
        return Subject(path.name, view, ask(view, View.review), options)


def _glance(subjects: Sequence[Subject]) -> pd.DataFrame:
    columns = {
        subject.name: {
            "what it is": subject.review.title,
            "answer": subject.review.answer,
            **_run_facts(subject),
        }
        for subject in subjects
    }
    return pd.DataFrame(columns).fillna("")


def _run_facts(subject: Subject) -> dict[str, str]:
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


def _numbers(subjects: Sequence[Subject]) -> pd.DataFrame:
    """Return the numbers by which both solutions are described, and their ratios."""
    described = (ask(subject.view, View.describe) for subject in subjects)
    columns = [table.select_dtypes("number").iloc[0] for table in described]
    table = pd.concat(columns, axis=1, join="inner", keys=[subject.name for subject in subjects])
    return table.assign(**{"second / first": columns[1] / columns[0]})


def _differences(subjects: Sequence[Subject]) -> pd.DataFrame:
    """Return the options that differ, by their keys with dots."""
    columns = {subject.name: dict(_flat(subject.options)) for subject in subjects}
    table = pd.DataFrame(columns, dtype=object).rename_axis("option").fillna("left out")
    return table[table.nunique(axis=1) > 1]


def _flat(node: Any, key: str = "") -> Iterator[tuple[str, str]]:
    if isinstance(node, Mapping):
        for name, value in node.items():
            yield from _flat(value, f"{key}.{name}" if key else str(name))
    elif isinstance(node, list) and any(isinstance(value, Mapping) for value in node):
        for i, value in enumerate(node):
            yield from _flat(value, f"{key}[{i}]")
    else:
        yield key, json.dumps(node, ensure_ascii=False)


def fronts_figure(subjects: list[Subject]) -> go.Figure | None:
    """Fronts, and what is compared, of two objectives of the same names, in one picture."""
    names = [column_names(subject.view.problem)[1] for subject in subjects]
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
