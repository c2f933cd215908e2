"""Data of the report page: values, constraint margins and figures of the solutions of a front.

Figures are compressed: arrays are stored as float32, and the common structure of similar figures is
stored once.
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
from mgeo.figures.front import MAX_HOVER_TEXTS
from mgeo.plugins.protocol import call_optional, get_column_names, has_override
from mgeo.plugins.view import View
from mgeo.report.loaded_run import LoadedRun
from mgeo.runs.summary import RepresentativeSolution, list_constraint_margins

#: Key of a placeholder for a value that differs between solutions.
PLACEHOLDER = "$placeholder"

Json = Any


def build_figure_json(
    figure: go.Figure | Mapping[str, Any], *, use_lists: bool = False
) -> dict[str, Json]:
    """Return the traces and layout of a figure as JSON values, without the layout's template.

    Parameters
    ----------
    figure
        Figure, or dict of its ``data`` and ``layout`` that is not validated.
    use_lists
        Whether to convert arrays to lists of numbers, for pages that read them. Otherwise, floats
        are encoded as arrays of 4 bytes each, which plotly.js decodes.
    """
    tree = figure.to_dict() if isinstance(figure, go.Figure) else figure
    layout = {key: value for key, value in tree["layout"].items() if key != "template"}
    values: dict[str, Json] = _to_json({"data": tree["data"], "layout": layout}, use_lists)
    return values


def _to_json(node: Any, use_lists: bool) -> Json:
    if isinstance(node, Mapping):
        if {"bdata", "dtype"} <= node.keys():
            return _to_json(_decode_array(node), use_lists)
        return {str(key): _to_json(value, use_lists) for key, value in node.items()}
    if isinstance(node, np.ndarray):
        packs = not use_lists and node.ndim == 1 and node.size and node.dtype.kind == "f"
        return _encode_array(node) if packs else _to_json(node.tolist(), use_lists)
    if isinstance(node, list | tuple):
        return [_to_json(value, use_lists) for value in node]
    if isinstance(node, np.generic):
        node = node.item()
    return None if isinstance(node, float) and not math.isfinite(node) else node


def _decode_array(node: Mapping[str, Any]) -> NDArray[Any]:
    """Return the array that plotly has encoded in a dict."""
    array = np.frombuffer(b64decode(node["bdata"]), node["dtype"])
    return array.reshape([int(n) for n in node["shape"].split(",")]) if "shape" in node else array


def _encode_array(array: NDArray[Any]) -> Json:
    """Return an array of floats in plotly's encoding, with 4 bytes each."""
    return {"dtype": "f4", "bdata": b64encode(array.astype("<f4").tobytes()).decode()}


def split_common(trees: Sequence[Json]) -> tuple[Json, list[list[Json]]]:
    """Split JSON trees into their common structure and the values that differ.

    Returns
    -------
    common
        Structure of the trees, with a placeholder ``{PLACEHOLDER: k}`` for each value that differs.
    values
        For each tree, the values of the placeholders 0, 1, ...
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
            _is_number_list(first)
        ):
            return [merge([node[i] for node in nodes]) for i in range(len(first))]
        key = json.dumps(nodes)  # Curves over equal times share one placeholder for the times.
        if key not in holes:
            holes[key] = len(columns)
            columns.append(nodes)
        return {PLACEHOLDER: holes[key]}

    common = merge(list(trees))
    return common, [[column[i] for column in columns] for i in range(len(trees))]


def format_script_json(value: Json) -> str:
    """Return JSON text that is safe inside an HTML script element."""
    text = json.dumps(value, allow_nan=False, separators=(",", ":"))
    for character in "<>&":
        text = text.replace(character, f"\\u{ord(character):04x}")
    return text


def _is_number_list(node: list[Json]) -> bool:
    return bool(node) and all(isinstance(value, int | float) for value in node)


#: Maximum number of solutions with figures in a report, which limits its size.
MAX_SOLUTIONS_WITH_FIGURES = 300


def build_solutions_json(loaded_run: LoadedRun) -> dict[str, Json]:
    """Return the data of all solutions; in large fronts, only some have figures and margins."""
    view = loaded_run.view
    rows = select_figure_rows(loaded_run.representatives, len(view.X))
    planned = view.select(rows)
    variables = Variables.from_problem(view.problem, KINDS)
    names, objectives = get_column_names(view.problem)
    picture = draw_front(view, loaded_run.title)
    return {
        "table": {"columns": [*names, *objectives], "rows": np.hstack([view.X, view.F]).tolist()},
        "objectives": len(objectives),
        "figure_rows": rows.tolist(),
        "summaries": _index_by_row(_list_summaries(planned), rows),
        "descriptions": _build_descriptions_json(planned, rows),
        "bounds": [variables.xl.tolist(), variables.xu.tolist()],
        "constraints": _build_margins_json(planned, rows),
        "labels": {str(solution.row): solution.label for solution in loaded_run.representatives},
        "front": None if picture is None else build_figure_json(picture, use_lists=True),
        "figures": build_figures_json(planned, rows),
    }


def select_figure_rows(
    representatives: Sequence[RepresentativeSolution],
    n: int,
    n_max: int = MAX_SOLUTIONS_WITH_FIGURES,
) -> NDArray[np.int64]:
    """Return the ascending rows of the solutions that have figures: at most `n_max` of n.

    In a large front, these are the representative solutions and evenly spaced solutions between
    them.

    Parameters
    ----------
    representatives
        Representative solutions.
    n
        Number of solutions, sorted by the first objective.
    n_max
        Maximum number of rows.
    """
    if n <= n_max:
        return np.arange(n)
    rows = [solution.row for solution in representatives][:n_max]
    spread = np.linspace(0, n - 1, n_max - len(rows)).round().astype(np.int64)
    return np.unique(np.concatenate([np.array(rows, dtype=np.int64), spread]))


def draw_front(view: View, title: str) -> go.Figure | None:
    """Return the figure of the front, whose points have their row as ``customdata``.

    The problem's own figure is used if it has ``customdata``, see ``docs/plugins.md``. With more
    than three objectives, the figure may be None.
    """
    if len(view.X) <= MAX_HOVER_TEXTS and has_override(view, View.figures):
        figure = call_optional(view, View.figures).get("front")
        if figure and any(getattr(trace, "customdata", None) is not None for trace in figure.data):
            return figure
    return view.default_front_figure(title)


def build_figures_json(view: View, rows: NDArray[np.int64]) -> Json:
    """Return the figures of single solutions, split into common structure and values.

    Parameters
    ----------
    view
        View of the solutions.
    rows
        Numbers of the solutions on the front.
    """
    drawings = call_optional(view, View.figure_dicts)
    if not any(drawings):
        return {"common": {}, "values": {}}
    common, values = split_common(
        [
            {str(name): build_figure_json(each) for name, each in figures.items()}
            for figures in drawings
        ]
    )
    return {"common": common, "values": _index_by_row(values, rows)}


def _list_summaries(view: View) -> list[str]:
    """Return the problem's summary of each solution, or empty texts."""
    return (
        call_optional(view, View.summaries)
        if has_override(view, View.summaries)
        else [""] * len(view.X)
    )


def _build_descriptions_json(view: View, rows: NDArray[np.int64]) -> Json:
    """Return the problem's description of each solution, or its objectives."""
    table = call_optional(view, View.describe)
    if not has_override(view, View.describe):
        table = table.iloc[:, : view.problem.n_obj]
    cells = [
        [format_cell(value) for value in row] for row in table.itertuples(index=False, name=None)
    ]
    return {"columns": [str(name) for name in table.columns], "rows": _index_by_row(cells, rows)}


def _build_margins_json(view: View, rows: NDArray[np.int64]) -> Json:
    """Return, for each solution, the name, satisfaction and text of each constraint."""
    margins = [
        [
            [limit.name, limit.is_satisfied, str(limit).removeprefix(f"{limit.name}: ")]
            for limit in each
        ]
        for each in list_constraint_margins(view)
    ]
    return _index_by_row(margins, rows)


def _index_by_row(values: Sequence[Json], rows: NDArray[np.int64]) -> dict[str, Json]:
    return dict(zip(map(str, rows.tolist()), values, strict=True))


def format_cell(value: Any) -> Json:
    """Return a number with seven digits, or any other value as text."""
    if isinstance(value, bool) or not isinstance(value, int | float | np.number):
        return str(value)
    number = float(value)
    return float(f"{number:.7g}") if np.isfinite(number) else str(number)
