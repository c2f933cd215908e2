"""Data of the report page: variables, objectives, margins and figures of each solution.

Figures are compressed. Arrays are stored as float32, and the structure that similar figures have in
common is stored once.
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

#: JSON key that marks a placeholder for a value that differs between solutions.
PLACEHOLDER = "$placeholder"

Json = Any


def build_figure_json(
    figure: go.Figure | Mapping[str, Any], *, use_lists: bool = False
) -> dict[str, Json]:
    """Convert a plotly figure to a dict of JSON values, without the layout template.

    Parameters
    ----------
    figure
        Figure, or a dict of its ``data`` and ``layout``, which is not validated.
    use_lists
        True to convert arrays to lists, for scripts that read the values. Otherwise, arrays of
        floats are encoded with 4 bytes per value, which plotly.js decodes.

    Returns
    -------
    dict
        ``data``, a list of traces, and ``layout``.
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
        is_encoded = not use_lists and node.ndim == 1 and node.size and node.dtype.kind == "f"
        return _encode_array(node) if is_encoded else _to_json(node.tolist(), use_lists)
    if isinstance(node, list | tuple):
        return [_to_json(value, use_lists) for value in node]
    if isinstance(node, np.generic):
        node = node.item()
    return None if isinstance(node, float) and not math.isfinite(node) else node


def _decode_array(node: Mapping[str, Any]) -> NDArray[Any]:
    """Decode an array that plotly has encoded as base64 text."""
    array = np.frombuffer(b64decode(node["bdata"]), node["dtype"])
    return array.reshape([int(n) for n in node["shape"].split(",")]) if "shape" in node else array


def _encode_array(array: NDArray[Any]) -> Json:
    """Encode an array of floats as base64 text in the format of plotly, with 4 bytes per value."""
    return {"dtype": "f4", "bdata": b64encode(array.astype("<f4").tobytes()).decode()}


def extract_common_structure(trees: Sequence[Json]) -> tuple[Json, list[list[Json]]]:
    """Split similar JSON trees into a common tree and the values that differ between the trees.

    Parameters
    ----------
    trees
        JSON values, at least one.

    Returns
    -------
    common
        JSON tree with a placeholder ``{PLACEHOLDER: k}`` in place of each value that differs.
    values
        Values of the placeholders 0, 1, ... of each tree.
    """
    placeholders: dict[str, int] = {}
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
        key = json.dumps(nodes)  # Curves with equal times share one placeholder.
        if key not in placeholders:
            placeholders[key] = len(columns)
            columns.append(nodes)
        return {PLACEHOLDER: placeholders[key]}

    common = merge(list(trees))
    return common, [[column[i] for column in columns] for i in range(len(trees))]


def format_script_json(value: Json) -> str:
    """Encode a value as JSON text that can be embedded in an HTML script element.

    The characters <, > and & are escaped.
    """
    text = json.dumps(value, allow_nan=False, separators=(",", ":"))
    for character in "<>&":
        text = text.replace(character, f"\\u{ord(character):04x}")
    return text


def _is_number_list(node: list[Json]) -> bool:
    return bool(node) and all(isinstance(value, int | float) for value in node)


#: Maximum number of solutions whose figures are in a report. It limits the size of the report.
MAX_SOLUTIONS_WITH_FIGURES = 300


def build_solutions_json(loaded_run: LoadedRun) -> dict[str, Json]:
    """Return the solutions of a run as a JSON object for the scripts of the report.

    The object contains designs, objectives, figures and constraint margins.

    Figures, descriptions and constraint margins are included for the rows in ``figure_rows``, which
    are some of the solutions of a large front, see `select_figure_rows`.
    """
    view = loaded_run.view
    rows = select_figure_rows(loaded_run.representatives, len(view.X))
    selected_view = view.select(rows)
    variables = Variables.from_problem(view.problem, KINDS)
    names, objectives = get_column_names(view.problem)
    front = draw_front(view, loaded_run.title)
    return {
        "table": {"columns": [*names, *objectives], "rows": np.hstack([view.X, view.F]).tolist()},
        "titles": [*names, *map(view.format_title, objectives)],
        "objectives": len(objectives),
        "figure_rows": rows.tolist(),
        "summaries": _index_by_row(_list_summaries(selected_view), rows),
        "descriptions": _build_descriptions_json(selected_view, rows),
        "bounds": [variables.xl.tolist(), variables.xu.tolist()],
        "constraints": _build_margins_json(selected_view, rows),
        "labels": {str(solution.row): solution.label for solution in loaded_run.representatives},
        "front": None if front is None else build_figure_json(front, use_lists=True),
        "figures": build_figures_json(selected_view, rows),
    }


def select_figure_rows(
    representatives: Sequence[RepresentativeSolution],
    n: int,
    n_max: int = MAX_SOLUTIONS_WITH_FIGURES,
) -> NDArray[np.int64]:
    """Select the solutions of a front for which the report contains figures.

    The selection consists of representative solutions and evenly spaced ones.

    All rows are returned if the front has at most `n_max` solutions.

    Parameters
    ----------
    representatives
        Representative solutions.
    n
        Number of solutions of the front, which are sorted by the first objective.
    n_max
        Maximum number of rows.

    Returns
    -------
    array of int, shape (k,)
        Row numbers in ascending order.
    """
    if n <= n_max:
        return np.arange(n)
    rows = [solution.row for solution in representatives][:n_max]
    spread = np.linspace(0, n - 1, n_max - len(rows)).round().astype(np.int64)
    return np.unique(np.concatenate([np.array(rows, dtype=np.int64), spread]))


def draw_front(view: View, title: str) -> go.Figure | None:
    """Draw a front in which the ``customdata`` of each point is the row number of the solution.

    The figure "front" of the problem is used if its points have ``customdata``, see
    ``docs/tutorials/plugin.md``. Otherwise, the objectives are drawn, or None is returned if there
    are more than three.

    Parameters
    ----------
    view
        View of the problem on the front.
    title
        Title of the default figure.
    """
    if len(view.X) <= MAX_HOVER_TEXTS and has_override(view, View.figures):
        figure = call_optional(view, View.figures).get("front")
        if figure and any(getattr(trace, "customdata", None) is not None for trace in figure.data):
            return figure
    return view.default_front_figure(title)


def build_figures_json(view: View, rows: NDArray[np.int64]) -> Json:
    """Convert the figures of all solutions to JSON values.

    The structure that the figures have in common is stored only once.

    Parameters
    ----------
    view
        View of the problem on the solutions.
    rows
        Row numbers of the solutions on the front.

    Returns
    -------
    dict
        ``common``, the structure of the figures by name, and ``values``, the values of the
        placeholders by row number.
    """
    figure_dicts = call_optional(view, View.figure_dicts)
    if not any(figure_dicts):
        return {"common": {}, "values": {}}
    common, values = extract_common_structure(
        [
            {str(name): build_figure_json(figure) for name, figure in figures.items()}
            for figures in figure_dicts
        ]
    )
    return {"common": common, "values": _index_by_row(values, rows)}


def _list_summaries(view: View) -> list[str]:
    """Return one summary per solution, or empty strings if the problem defines no summaries."""
    return (
        call_optional(view, View.summaries)
        if has_override(view, View.summaries)
        else [""] * len(view.X)
    )


def _build_descriptions_json(view: View, rows: NDArray[np.int64]) -> Json:
    """Return the problem's table of solutions as column names and rows of JSON values."""
    table = call_optional(view, View.describe)
    if not has_override(view, View.describe):
        table = table.iloc[:, : view.problem.n_obj]
    cells = [
        [format_cell(value) for value in row] for row in table.itertuples(index=False, name=None)
    ]
    return {
        "columns": [view.format_title(str(name)) for name in table.columns],
        "rows": _index_by_row(cells, rows),
    }


def _build_margins_json(view: View, rows: NDArray[np.int64]) -> Json:
    """Return the constraint margins of each solution.

    Each margin is a list [name, is_satisfied, text].
    """
    margins = [
        [
            [margin.name, margin.is_satisfied, str(margin).removeprefix(f"{margin.name}: ")]
            for margin in solution_margins
        ]
        for solution_margins in list_constraint_margins(view)
    ]
    return _index_by_row(margins, rows)


def _index_by_row(values: Sequence[Json], rows: NDArray[np.int64]) -> dict[str, Json]:
    return dict(zip(map(str, rows.tolist()), values, strict=True))


def format_cell(value: Any) -> Json:
    """Convert a table cell to a JSON value.

    Finite numbers are rounded to seven significant digits. All other cells are converted to
    strings.

    Numbers are rounded to seven significant digits, and other cells are converted to strings.
    """
    if isinstance(value, bool) or not isinstance(value, int | float | np.number):
        return str(value)
    number = float(value)
    return float(f"{number:.7g}") if np.isfinite(number) else str(number)
