"""Figures as small JSON: float32 arrays, and of many like figures only what differs."""

from __future__ import annotations

import base64
import json
import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import plotly.graph_objects as go

#: Key of an object that stands for a value which differs from solution to solution.
HOLE = "$differs"

Json = Any


def figure_json(figure: go.Figure) -> dict[str, Json]:
    """Traces and layout as JSON values; arrays of floats as float32, as plotly.js reads them.

    The layout's template is left out: the page's colors take its place.
    """
    tree = figure.to_plotly_json()
    layout = {key: value for key, value in tree.get("layout", {}).items() if key != "template"}
    return {"data": _plain(tree.get("data", [])), "layout": _plain(layout)}


def decoded(tree: Json) -> Json:
    """A tree in which encoded arrays of plotly's are lists of numbers again."""
    if isinstance(tree, Mapping):
        if "bdata" in tree:
            return [_number(value) for value in _array(tree).tolist()]
        return {key: decoded(value) for key, value in tree.items()}
    return [decoded(value) for value in tree] if isinstance(tree, list) else tree


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


def _plain(value: Any) -> Json:
    if isinstance(value, Mapping):
        if "bdata" in value and "dtype" in value:
            return _encoded(_array(value))
        return {str(key): _plain(entry) for key, entry in value.items()}
    if isinstance(value, np.ndarray) and value.dtype.kind in "iuf" and value.ndim == 1:
        return _encoded(value)
    if isinstance(value, np.ndarray | list | tuple):
        return [_plain(entry) for entry in value]
    if isinstance(value, np.generic):
        value = value.item()
    if value is None or isinstance(value, bool | int | str):
        return value
    return _number(value) if isinstance(value, float) else str(value)


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _array(encoded: Mapping[str, Any]) -> np.ndarray:
    """An array as plotly encodes it."""
    flat = np.frombuffer(base64.b64decode(encoded["bdata"]), dtype=np.dtype(encoded["dtype"]))
    shape = str(encoded.get("shape", "")).replace(" ", "")
    return flat.reshape([int(n) for n in shape.split(",")]) if shape else flat


def _encoded(array: np.ndarray) -> Json:
    if array.dtype == np.float64 and array.ndim == 1:
        array = array.astype("<f4")
    if array.ndim != 1 or array.dtype.itemsize > 4:
        return _plain(array.tolist())
    little = np.ascontiguousarray(array, dtype=array.dtype.newbyteorder("<"))
    name = f"{array.dtype.kind}{array.dtype.itemsize}"
    return {"dtype": name, "bdata": base64.b64encode(little.tobytes()).decode()}
