"""Data of the report's page: values, constraint margins and figures of the solutions of a front.

Figures are small JSON: float32 arrays, and the common structure of like figures only once.
"""

from __future__ import annotations

import json
import math
from base64 import b64decode, b64encode
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import plotly.graph_objects as go
from numpy.typing import NDArray

from mgeo.algorithms.variables import KINDS, Variables
from mgeo.figures.front import MOST_TEXTS
from mgeo.plugins.protocol import ask, column_names, is_own
from mgeo.plugins.view import View
from mgeo.report.shown_run import ShownRun
from mgeo.runs.answer import RepresentativeSolution, limits

#: Key of an object that stands for a value which differs from solution to solution.
HOLE = "$differs"

Json = Any


def figure_json(figure: go.Figure | Mapping[str, Any], *, lists: bool = False) -> dict[str, Json]:
    """Return traces and layout of a figure as JSON values, without the layout's template.

    Parameters
    ----------
    figure
        A figure, or a dict of its ``data`` and ``layout`` that is not validated.
    lists
        Whether arrays become lists of numbers, for a page that reads them. Otherwise floats become
        encoded arrays of 4 bytes each, which plotly.js decodes.
    """
    tree = figure.to_dict() if isinstance(figure, go.Figure) else figure
    layout = {key: value for key, value in tree["layout"].items() if key != "template"}
    found: dict[str, Json] = _json({"data": tree["data"], "layout": layout}, lists)
    return found


def _json(node: Any, lists: bool) -> Json:
    if isinstance(node, Mapping):
        if {"bdata", "dtype"} <= node.keys():
            return _json(_decoded(node), lists)
        return {str(key): _json(value, lists) for key, value in node.items()}
    if isinstance(node, np.ndarray):
        packs = not lists and node.ndim == 1 and node.size and node.dtype.kind == "f"
        return _packed(node) if packs else _json(node.tolist(), lists)
    if isinstance(node, list | tuple):
        return [_json(value, lists) for value in node]
    if isinstance(node, np.generic):
        node = node.item()
    return None if isinstance(node, float) and not math.isfinite(node) else node


def _decoded(node: Mapping[str, Any]) -> NDArray[Any]:
    """Return an array that plotly has encoded."""
    array = np.frombuffer(b64decode(node["bdata"]), node["dtype"])
    return array.reshape([int(n) for n in node["shape"].split(",")]) if "shape" in node else array


def _packed(array: NDArray[Any]) -> Json:
    """Return floats of 4 bytes as plotly.js decodes them."""
    return {"dtype": "f4", "bdata": b64encode(array.astype("<f4").tobytes()).decode()}


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


def solutions_json(shown: ShownRun) -> dict[str, Json]:
    """Return the data of all solutions; of a large front only some have figures and limits."""
    view = shown.view
    rows = planned_rows(shown.representatives, len(view.X))
    planned = view.take(rows)
    variables = Variables.of(view.problem, KINDS)
    names, objectives = column_names(view.problem)
    picture = front_picture(view, shown.title)
    return {
        "table": {"columns": [*names, *objectives], "rows": np.hstack([view.X, view.F]).tolist()},
        "objectives": len(objectives),
        "planned": rows.tolist(),
        "answers": _by_row(_answers(planned), rows),
        "described": _described(planned, rows),
        "bounds": [variables.xl.tolist(), variables.xu.tolist()],
        "limits": _limits(planned, rows),
        "labels": {str(solution.row): solution.label for solution in shown.representatives},
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
    """Return the figure of the front, whose points have their row as ``customdata``.

    It is the problem's own figure where that has ``customdata``, see ``docs/plugins.md``. Above
    three objectives it may be None.
    """
    if len(view.X) <= MOST_TEXTS and is_own(view, View.figures):
        figure = ask(view, View.figures).get("front")
        if figure and any(getattr(trace, "customdata", None) is not None for trace in figure.data):
            return figure
    return view.plain_front(title)


def plans_json(view: View, rows: NDArray[np.int64]) -> Json:
    """Return figures of single solutions: their common structure, and the values of each.

    Parameters
    ----------
    rows
        Numbers of the solutions on the front.
    """
    found = ask(view, View.drawings)
    if not any(found):
        return {"common": {}, "values": {}}
    common, values = shared(
        [{str(name): figure_json(each) for name, each in figures.items()} for figures in found]
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


def _by_row(values: Sequence[Json], rows: NDArray[np.int64]) -> dict[str, Json]:
    return dict(zip(map(str, rows.tolist()), values, strict=True))


def cell(value: Any) -> Json:
    """A number as such, all else as text."""
    if isinstance(value, bool) or not isinstance(value, int | float | np.number):
        return str(value)
    number = float(value)
    return float(f"{number:.7g}") if np.isfinite(number) else str(number)
