"""The solutions of a front as the report shows them: values, limits and figures of each.

Figures are small JSON: float32 arrays, and of many like figures only what differs.
"""

from __future__ import annotations

import json
import math
from base64 import b64decode, b64encode
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import plotly.graph_objects as go
from numpy.typing import NDArray
from pymoo.core.problem import Problem

from mgeo.figures.front import MOST_TEXTS
from mgeo.figures.motion import check_motion
from mgeo.plugins.shown import ask
from mgeo.plugins.view import View, is_own
from mgeo.runs.answer import RepresentativeSolution, default_solution, limits
from mgeo.store.run import Run
from mgeo.store.run_folder import front_table

#: Key of an object that stands for a value which differs from solution to solution.
HOLE = "$differs"

Json = Any


def figure_json(figure: go.Figure, *, lists: bool = False) -> dict[str, Json]:
    """Traces and layout as JSON values; floats as float32, in the arrays that plotly.js reads.

    The layout's template is left out: the page's colors take its place.

    Parameters
    ----------
    lists
        Whether arrays are lists of numbers instead, for a page that looks into them.
    """

    def encoded(node: dict[str, Json]) -> Json:
        if not {"bdata", "dtype"} <= node.keys():
            return node
        array = np.frombuffer(b64decode(node["bdata"]), node["dtype"])
        if "shape" in node:
            array = array.reshape([int(n) for n in node["shape"].split(",")])
        elif array.dtype == np.float64:
            array = array.astype("<f4")
            node = {"dtype": "f4", "bdata": b64encode(array.tobytes()).decode()}
        if not (lists or array.ndim > 1):
            return node
        return json.loads(json.dumps(array.tolist()), parse_constant=lambda name: None)

    tree: dict[str, Json] = json.loads(figure.to_json(engine="json"), object_hook=encoded)
    tree["layout"].pop("template", None)
    return tree


def tree_json(node: Any) -> Json:
    """The same of plotly's tree of a figure, its data and layout, which nobody validates first.

    Raises
    ------
    TypeError
        For what JSON cannot hold.
    """
    if isinstance(node, str | bool | int) or node is None:
        return node
    if isinstance(node, float | np.number):
        value = node.item() if isinstance(node, np.number) else node
        return value if isinstance(value, int) or math.isfinite(value) else None
    if isinstance(node, Mapping):
        return {str(key): tree_json(value) for key, value in node.items()}
    if isinstance(node, np.ndarray) and node.dtype.kind in "fiu" and node.ndim == 1 and node.size:
        return _packed(node)
    if isinstance(node, np.ndarray):
        return tree_json(node.tolist())
    if isinstance(node, list | tuple):
        return [tree_json(value) for value in node]
    raise TypeError(f"{node!r:.80} in a figure: expected what JSON can hold, or an array")


def _packed(array: NDArray[Any]) -> Json:
    """An array in the form that plotly.js reads: floats of 4 bytes, whole numbers as they fit."""
    kinds = ("f4",) if array.dtype.kind == "f" else ("i1", "i2", "i4")
    fitting = (k for k in kinds if k == "f4" or not (array != array.astype(k)).any())
    kind = next(fitting, None)
    if kind is None:
        return array.tolist()
    return {"dtype": kind, "bdata": b64encode(array.astype(f"<{kind}").tobytes()).decode()}


def shared(trees: Sequence[Json]) -> tuple[Json, list[list[Json]]]:
    """What JSON trees have in common, and what each one puts into its holes.

    Returns
    -------
    common
        The trees' structure, with ``{HOLE: k}`` where they differ.
    values
        For each tree its values of the holes 0, 1, ...
    """
    holes: dict[str, int] = {}
    columns: list[list[Json]] = []

    def merge(nodes: list[Json]) -> Json:
        first = nodes[0]
        if all(node == first for node in nodes[1:]):
            return first
        if all(isinstance(node, dict) and node.keys() == first.keys() for node in nodes):
            return {key: merge([node[key] for node in nodes]) for key in first}
        if all(isinstance(node, list) and len(node) == len(first) for node in nodes) and not (
            _numbers(first)
        ):
            return [merge([node[i] for node in nodes]) for i in range(len(first))]
        key = json.dumps(nodes)  # curves over the same times have these in one hole
        if key not in holes:
            holes[key] = len(columns)
            columns.append(nodes)
        return {HOLE: holes[key]}

    common = merge(list(trees))
    return common, [[column[i] for column in columns] for i in range(len(trees))]


def script_json(value: Json) -> str:
    """JSON that is safe inside a script element, whatever strings are in it."""
    text = json.dumps(value, allow_nan=False, separators=(",", ":"))
    for character in "<>&":
        text = text.replace(character, f"\\u{ord(character):04x}")
    return text


def _numbers(node: list[Json]) -> bool:
    return bool(node) and all(isinstance(value, int | float) for value in node)


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
