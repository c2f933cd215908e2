"""The solutions of a front as the report shows them: values, limits and figures of each."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
import plotly.graph_objects as go
from numpy.typing import NDArray
from pymoo.core.problem import Problem

from mgeo.figures.front import MOST_OBJECTIVES, front_figure
from mgeo.figures.motion import check_motion
from mgeo.plugins import protocol
from mgeo.report.encode import Json, decoded, figure_json, shared
from mgeo.runs.representative import RepresentativeSolution
from mgeo.runs.solve import Outcome

#: Solutions whose figures go into a report, so that its size stays bounded.
MOST_PLANS = 300

#: Points up to which each has its variables in its hover text, and the plugin draws the front.
_MOST_TEXTS = 2000


def planned_rows(
    chosen: Sequence[RepresentativeSolution], n: int, most: int = MOST_PLANS
) -> NDArray[np.int64]:
    """Rows that get figures of their own: all, or representative ones and others between them.

    Ascending; the front is ordered by its first objective.
    """
    if n <= most:
        return np.arange(n)
    rows = [solution.row for solution in chosen][:most]
    spread = np.linspace(0, n - 1, most - len(rows)).round().astype(np.int64)
    return np.unique(np.concatenate([np.array(rows, dtype=np.int64), spread]))


def front_picture(problem: Problem, outcome: Outcome, title: str) -> go.Figure | None:
    """The picture of the front, whose points carry their row as ``customdata``; None if none can.

    It is the plugin's own where its points do so, see ``docs/plugins.md``.
    """
    n = len(outcome.X)
    figure = None
    if n <= _MOST_TEXTS:
        figure = protocol.front_figure(problem, outcome.X)
        if figure is not None and not _numbered(figure, n):
            figure = None
    if figure is None:
        if len(outcome.objectives) > MOST_OBJECTIVES:
            return None
        figure = front_figure(outcome.X, outcome.F, outcome.variables, outcome.objectives, title)
        if n > _MOST_TEXTS:
            numbered = {"customdata": np.arange(n), "hovertext": None, "hoverinfo": "all"}
            figure.update_traces(numbered, selector={"mode": "markers"})
    return figure


def front_json(figure: go.Figure | None) -> Json:
    """The picture of the front for the page, which looks points up: as lists."""
    return None if figure is None else decoded(figure_json(figure))


def plans_json(problem: Problem, X: NDArray[np.float64], rows: NDArray[np.int64]) -> Json:
    """Figures of single solutions: what all have in common, and each one's own values.

    Raises
    ------
    ValueError
        If the problem's `solution_figures` returns another number of entries, or a figure moves
        in no way that the page knows.
    """
    drawn = protocol.solution_figures(problem, X[rows])
    if not drawn:
        return {"common": {}, "values": {}}
    for figure in (figure for figures in drawn for figure in figures.values()):
        check_motion(figure)
    trees = [{name: figure_json(figure) for name, figure in figures.items()} for figures in drawn]
    common, values = shared(trees)
    return {"common": common, "values": _by_row(values, rows)}


def described(problem: Problem, outcome: Outcome, rows: NDArray[np.int64]) -> Json:
    """Solutions in the problem's own terms, or else their objectives."""
    table = protocol.describe(problem, outcome.X[rows])
    if table is None:
        table = pd.DataFrame(outcome.F[rows], columns=list(outcome.objectives))
    return {"columns": [str(name) for name in table.columns], "rows": _by_row(cells(table), rows)}


def limits_json(problem: Problem, X: NDArray[np.float64], rows: NDArray[np.int64]) -> Json:
    """Constraints of each solution: names, and values that are at most 0 where a limit is kept."""
    count = problem.n_ieq_constr
    if not count:
        return {"names": [], "rows": {}}
    G = problem.evaluate(X[rows], return_values_of=["G"])
    names = getattr(problem, "constraint_names", None) or [f"g{j + 1}" for j in range(count)]
    return {"names": [str(name) for name in names], "rows": _by_row(rounded(np.asarray(G)), rows)}


def _by_row(values: Sequence[Json], rows: NDArray[np.int64]) -> dict[str, Json]:
    return dict(zip(map(str, rows.tolist()), values, strict=True))


def rounded(values: NDArray[np.float64], digits: int = 6) -> Json:
    """Nested lists of numbers with so many digits, None for what is not finite."""
    return [
        [float(f"{v:.{digits}g}") if np.isfinite(v) else None for v in row]
        for row in values.tolist()
    ]


def cells(table: pd.DataFrame) -> Json:
    """Rows of a table as JSON: numbers stay numbers, all else is text."""
    return [[_cell(value) for value in row] for row in table.itertuples(index=False, name=None)]


def _cell(value: Any) -> Json:
    if isinstance(value, bool | str):
        return str(value)
    if isinstance(value, int | float | np.number):
        number = float(value)
        return float(f"{number:.7g}") if np.isfinite(number) else str(number)
    return str(value)


def _numbered(figure: go.Figure, n: int) -> bool:
    """Whether points of the figure say which row of n they are."""
    found = [getattr(trace, "customdata", None) for trace in figure.data]
    columns = [np.asarray(data) for data in found if data is not None and len(data)]
    return bool(columns) and all(
        column.ndim == 1 and column.dtype.kind in "iu" and 0 <= column.min() <= column.max() < n
        for column in columns
    )
