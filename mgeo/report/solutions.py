"""The solutions of a front as the report shows them: values, limits and figures of each."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import plotly.graph_objects as go
from numpy.typing import NDArray
from pymoo.core.problem import Problem

from mgeo.figures import MOST_TEXTS
from mgeo.figures.motion import check_motion
from mgeo.plugins.shown import ask
from mgeo.plugins.view import View, is_own
from mgeo.report.encode import Json, figure_json, shared, tree_json
from mgeo.runs.answer import RepresentativeSolution, default_solution
from mgeo.runs.limits import limits
from mgeo.store.run import Run
from mgeo.store.run_folder import front_table

#: Solutions whose figures go into a report, so that its size stays bounded.
MOST_PLANS = 300


def solutions_json(
    view: View, run: Run, chosen: Sequence[RepresentativeSolution], title: str
) -> Json:
    """What the page shows of the solutions, by name; all of them have their values."""
    outcome = run.outcome
    rows = planned_rows(chosen, len(view.X))
    planned = view.take(rows)
    front = front_table(outcome)
    picture = front_picture(view, title)
    return {
        "table": {"columns": list(front.columns), "rows": front.to_numpy().tolist()},
        "objectives": len(outcome.objectives),
        "planned": rows.tolist(),
        "answers": _by_row(_answers(planned), rows),
        "described": _described(planned, rows),
        "bounds": _bounds(view.problem),
        "limits": _limits(planned, rows),
        "labels": {str(solution.row): solution.label for solution in chosen},
        "first": 0 if outcome.nearest else default_solution(view.problem, outcome.F).row,
        "front": None if picture is None else figure_json(picture, lists=True),
        "plans": plans_json(planned, rows),
    }


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


def front_picture(view: View, title: str) -> go.Figure | None:
    """The picture of the front, whose points carry their row as ``customdata``; None if none can.

    It is the plugin's own where its points do so, see ``docs/plugins.md``.
    """
    n = len(view.X)
    if n <= MOST_TEXTS and is_own(view, View.figures):
        figure = ask(view, View.figures).get("front")
        if figure is not None and _numbered(figure, n):
            return figure
    figure = view.plain_front(title)
    if figure is not None and n > MOST_TEXTS:
        numbered = {"customdata": np.arange(n), "hovertext": None, "hoverinfo": "all"}
        figure.update_traces(numbered, selector={"mode": "markers"})
    return figure


def plans_json(view: View, rows: NDArray[np.int64]) -> Json:
    """Figures of single solutions: what all have in common, and each one's own values.

    `rows` are their numbers on the front.

    Raises
    ------
    ValueError
        If the problem's `solution_figures` returns another number of entries, or a figure moves
        in no way that the page knows.
    """
    drawn = ask(view, View.drawings) if is_own(view, View.drawings) else None
    found: Sequence[Mapping[str, Any]] = (
        ask(view, View.solution_figures) if drawn is None else drawn
    )
    if not any(found):
        return {"common": {}, "values": {}}
    for figure in (figure for figures in found for figure in figures.values()):
        check_motion(figure)
    as_json: Callable[[Any], Json] = figure_json if drawn is None else tree_json
    common, values = shared(
        [{str(name): as_json(each) for name, each in figures.items()} for figures in found]
    )
    return {"common": common, "values": _by_row(values, rows)}


def _answers(view: View) -> list[str]:
    """The problem's own: of any other a card shows the objectives anyway."""
    return ask(view, View.answers) if is_own(view, View.answers) else [""] * len(view.X)


def _described(view: View, rows: NDArray[np.int64]) -> Json:
    """Solutions in the problem's own terms, or else their objectives: variables follow anyway."""
    table = ask(view, View.describe)
    if not is_own(view, View.describe):
        table = table.iloc[:, : view.problem.n_obj]
    cells = [[cell(value) for value in row] for row in table.itertuples(index=False, name=None)]
    return {"columns": [str(name) for name in table.columns], "rows": _by_row(cells, rows)}


def _limits(view: View, rows: NDArray[np.int64]) -> Json:
    """Limits of each solution: name, whether it is kept, and the numbers of it in words."""
    told = [
        [[limit.name, limit.kept, str(limit).removeprefix(f"{limit.name}: ")] for limit in each]
        for each in limits(view)
    ]
    return _by_row(told, rows)


def _bounds(problem: Problem) -> Json:
    """Lower and upper bounds, empty where the problem has none for each variable."""
    bounds = problem.xl, problem.xu
    known = all(isinstance(bound, np.ndarray) and bound.dtype.kind in "biuf" for bound in bounds)
    return [bound.tolist() for bound in bounds] if known else [[], []]


def _by_row(values: Sequence[Json], rows: NDArray[np.int64]) -> dict[str, Json]:
    return dict(zip(map(str, rows.tolist()), values, strict=True))


def cell(value: Any) -> Json:
    """A number as such, all else as text."""
    if isinstance(value, bool) or not isinstance(value, int | float | np.number):
        return str(value)
    number = float(value)
    return float(f"{number:.7g}") if np.isfinite(number) else str(number)


def _numbered(figure: go.Figure, n: int) -> bool:
    """Whether points of the figure say which row of n they are."""
    found = [getattr(trace, "customdata", None) for trace in figure.data]
    columns = [np.asarray(data) for data in found if data is not None and len(data)]
    return bool(columns) and all(
        column.ndim == 1 and column.dtype.kind in "iu" and 0 <= column.min() <= column.max() < n
        for column in columns
    )
