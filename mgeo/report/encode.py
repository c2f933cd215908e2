"""Figures as small JSON: float32 arrays, and of many like figures only what differs."""

from __future__ import annotations

import json
import math
from base64 import b64decode, b64encode
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import plotly.graph_objects as go
from numpy.typing import NDArray

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
