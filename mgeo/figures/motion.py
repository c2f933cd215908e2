"""Figures that move: three-dimensional traces that turn about the origin as time goes by.

A page computes every picture from a few turns, so that a moving figure costs as little as a still
one, and starts only when it is told to. In ``layout.meta["motion"]`` of the plotly figure stand

``end``
    Its last time [s]; the first is 0.
``turns``
    By name, each a dict of ``times``, ascending from 0, k + 1 of them [s], and ``x``, ``y``, ``z``,
    k each: the rotation vector [deg] from one time to the next, about the axes of what turns,
    which is how a body at constant rates moves. A turn may be several revolutions. Beyond the last
    time nothing moves.
``phases``
    A list of dicts ``name``, ``from``, ``to`` [s] and, if it is to be seen on the time line,
    ``shaded``: what is told beside the time while it lasts. May be left out.

A trace of type ``scatter3d`` or ``mesh3d`` turns if its ``meta["turn"]`` names one of the turns,
from where it is drawn, and is faint during the phase that ``meta["faint"]`` names.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import plotly.graph_objects as go

_TYPES = ("scatter3d", "mesh3d")
_TURN = "times that ascend from 0 and x, y, z of one number less, all finite"


def motion_of(figure: go.Figure) -> Any:
    """Return the motion of a figure, or None if it is still."""
    meta = figure.layout.meta
    return meta.get("motion") if isinstance(meta, Mapping) else None


def check_motion(figure: go.Figure) -> None:
    """Check that the motion of a figure, if it has one, has the form described above.

    Raises
    ------
    ValueError
        If a part of the motion has another form.
    """
    motion, turns = motion_of(figure), {}
    if motion is not None:
        has_keys = isinstance(motion, Mapping) and {"end", "turns"} <= motion.keys()
        _require(has_keys, "motion", "a dict of end and turns", motion)
        turns = motion["turns"]
        for name, turn in turns.items():
            _require(_is_turn(turn), f"motion: turns[{name!r}]", _TURN, turn)
    for trace in figure.data:
        if isinstance(trace.meta, Mapping) and "turn" in trace.meta:
            name = trace.meta["turn"]
            _require(name in turns, "turn of a trace", f"one of {list(turns)}", name)
            _require(trace.type in _TYPES, "turning trace", " or ".join(_TYPES), trace.type)


def _require(condition: bool, name: str, expected: str, found: Any) -> None:
    if not condition:
        raise ValueError(f"{name} = {found!r}: expected {expected}")


def _is_turn(turn: Any) -> bool:
    try:
        times, *vector = (np.asarray(turn[key], dtype=float) for key in ("times", "x", "y", "z"))
    except (KeyError, TypeError, ValueError):
        return False
    ascend = times.ndim == 1 and times.size > 1 and times[0] == 0.0 and (np.diff(times) > 0.0).all()
    matches = all(part.shape == (times.size - 1,) for part in vector)
    return bool(ascend and matches and np.isfinite([times[1:], *vector]).all())
