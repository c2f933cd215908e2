"""Format of animated three-dimensional figures, whose traces rotate about the origin over time.

The page computes each frame from a few rotations, so that an animated figure is as small as a
static one. The animation starts on demand. ``layout.meta["motion"]`` of the plotly figure has these
keys:

``end``
    Final time [s]; the first time is 0.
``rotations``
    Rotations by name. Each is a dict of ``times`` [s], k + 1 ascending values from 0, and ``x``,
    ``y``, ``z``, k values each: the rotation vector [deg] between consecutive times, about the
    axes of the rotating trace, at constant rate. It may exceed one revolution. There is no
    rotation after the last time.
``phases``
    Optional list of dicts of ``name``, ``from``, ``to`` [s] and optionally ``shaded``. The name
    is shown beside the time during the phase, and ``shaded`` marks the phase on the time line.

A trace of type ``scatter3d`` or ``mesh3d`` rotates if its ``meta["rotation"]`` is the name of a
rotation; its data are the initial position. It is faint during the phase ``meta["faint"]``.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import plotly.graph_objects as go

_TRACE_TYPES = ("scatter3d", "mesh3d")
_ROTATION_FORM = "times that ascend from 0, and x, y and z with one number less, all finite"


def get_motion(figure: go.Figure) -> Any:
    """Return the animation in the metadata of a figure, or None if the figure is static."""
    meta = figure.layout.meta
    return meta.get("motion") if isinstance(meta, Mapping) else None


def validate_motion(figure: go.Figure) -> None:
    """Raise an error if the animation in the metadata of a figure is invalid.

    The module docstring describes the format, which report pages require.

    Raises
    ------
    ValueError
        If a part of the animation is invalid.
    """
    motion, rotations = get_motion(figure), {}
    if motion is not None:
        has_keys = isinstance(motion, Mapping) and {"end", "rotations"} <= motion.keys()
        _require(has_keys, "motion", "a dict with the keys end and rotations", motion)
        rotations = motion["rotations"]
        for name, rotation in rotations.items():
            where = f"motion: rotations[{name!r}]"
            _require(_is_rotation(rotation), where, _ROTATION_FORM, rotation)
    for trace in figure.data:
        if isinstance(trace.meta, Mapping) and "rotation" in trace.meta:
            name, types = trace.meta["rotation"], " or ".join(_TRACE_TYPES)
            _require(name in rotations, "rotation of a trace", f"one of {list(rotations)}", name)
            _require(trace.type in _TRACE_TYPES, "type of a rotating trace", types, trace.type)


def _require(condition: bool, name: str, expected: str, value: Any) -> None:
    if not condition:
        raise ValueError(f"{name} = {value!r}: expected {expected}")


def _is_rotation(rotation: Any) -> bool:
    try:
        times, *components = (
            np.asarray(rotation[key], dtype=float) for key in ("times", "x", "y", "z")
        )
    except (KeyError, TypeError, ValueError):
        return False
    has_times = times.ndim == 1 and times.size > 1 and times[0] == 0.0
    is_ascending = has_times and (np.diff(times) > 0.0).all()
    has_equal_sizes = all(part.shape == (times.size - 1,) for part in components)
    return bool(is_ascending and has_equal_sizes and np.isfinite([times[1:], *components]).all())
