"""Animated figure of the attitude of one plan in space.

The figure shows the initial attitude. Its ``layout.meta["motion"]`` and the ``meta`` of its traces
contain the rotations in the format of `mgeo.figures.motion`, which report pages animate.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from mgeo.figures.style import COLORS, GRAY
from mgeo_attitude._typing import Floats
from mgeo_attitude.environment.environment import Environment
from mgeo_attitude.maneuvers.schedule import RateIntervals
from mgeo_attitude.problem import AttitudeManeuverProblem
from mgeo_attitude.trajectory.trajectory import Trajectory
from mgeo_attitude.view.figures.style import build_title

SHADOW = "Earth's shadow"

#: Largest rotation angle of an interval that results from merging the steps of a ramp [rad].
_MAX_MERGED_ROTATION = np.radians(10.0)
#: Number of rotations of the Sun direction and of the field direction over the scenario.
_N_DIRECTION_ROTATIONS = 400
#: Half edge lengths of the drawn body along x, y and z.
_HALF_EDGES = (0.2, 0.32, 0.12)


def compute_body_rotations(
    intervals: RateIntervals, attitude: Floats, step: float
) -> dict[str, Floats]:
    """Compute the rotations between successive attitudes for an animation.

    Parameters
    ----------
    intervals : RateIntervals
        Intervals of constant body rate.
    attitude : array, shape (n + 1, 3, 3)
        Attitude matrix from GCRS to body at every step of the filter.
    step : float
        Step size of the filter [s].

    Returns
    -------
    dict
        ``times`` [s], shape (k + 1,), at which the animated attitude equals that of the filter; and
        ``x``, ``y``, ``z`` [deg], shape (k,), the rotation vectors from each time to the next in
        axes that rotate with the body and initially coincide with those of GCRS.
    """
    rotations = intervals.rates * np.diff(intervals.times)[:, None]
    angles = np.linalg.norm(rotations, axis=1)
    is_long = angles > _MAX_MERGED_ROTATION  # It may be several revolutions.
    ends = np.diff(np.cumsum(angles) // _MAX_MERGED_ROTATION, append=np.inf) > 0.0
    ends |= is_long | np.append(is_long[1:], True)
    edges = np.append(0, np.flatnonzero(ends) + 1)
    times = intervals.times[edges]
    edge_attitudes = attitude[np.rint(times / step).astype(np.int64)]
    merged = Rotation.from_matrix(
        edge_attitudes[:-1] @ edge_attitudes[1:].transpose(0, 2, 1)
    ).as_rotvec()
    is_single = np.diff(edges) == 1
    merged[is_single] = rotations[edges[:-1][is_single]]
    return _build_rotations(times, merged @ attitude[0])


def compute_direction_rotations(times: Floats, vectors: Floats) -> dict[str, Floats]:
    """Compute the smallest rotations between successive directions for an animation.

    Parameters
    ----------
    times : array, shape (k + 1,)
        Times of the directions [s].
    vectors : array, shape (k + 1, 3)
        Directions in inertial axes, of any length.

    Returns
    -------
    dict
        Format of `compute_body_rotations`. The axes of the rotation vectors rotate with the
        direction and initially coincide with the inertial axes.
    """
    unit = vectors / np.linalg.norm(vectors, axis=1)[:, None]
    normal = np.cross(unit[:-1], unit[1:])
    sine = np.linalg.norm(normal, axis=1)
    angle = np.arctan2(sine, np.einsum("ki,ki->k", unit[:-1], unit[1:]))
    inertial = normal * (angle / np.where(sine > 0.0, sine, 1.0))[:, None]
    rotating, total = np.empty_like(inertial), Rotation.identity()
    for i, rotation in enumerate(inertial):
        rotating[i] = total.inv().apply(rotation)
        total = Rotation.from_rotvec(rotation) * total
    return _build_rotations(times, rotating)


def compute_sun_field_rotations(environment: Environment) -> dict[str, dict[str, Floats]]:
    """Compute the rotations that animate the Sun direction and the magnetic field direction.

    The result is a dict with the keys ``Sun`` and ``field``. See `compute_direction_rotations` for
    the format of its values.
    """
    last = len(environment.times) - 1
    steps = np.unique(np.rint(np.linspace(0, last, _N_DIRECTION_ROTATIONS + 1)).astype(np.int64))
    times = environment.times[steps]
    vectors = {"Sun": environment.sun, "field": environment.field}
    return {
        name: compute_direction_rotations(times, inertial[steps])
        for name, inertial in vectors.items()
    }


def draw_attitude(
    problem: AttitudeManeuverProblem,
    trajectory: Trajectory,
    inertial: dict[str, dict[str, Floats]],
    shadow: Sequence[tuple[float, float]],
) -> dict[str, Any]:
    """Draw an animated figure of the satellite with the Sun and field directions in inertial space.

    Parameters
    ----------
    problem : AttitudeManeuverProblem
    trajectory : Trajectory
    inertial : dict
        Rotations of Sun and field; see `compute_sun_field_rotations`.
    shadow : sequence of tuple
        Start and end [s] of each eclipse.

    Returns
    -------
    dict
        Plotly figure as a dict of ``data`` and ``layout``.
    """
    environment, intervals, attitude = (
        problem.environment,
        trajectory.intervals,
        trajectory.attitude,
    )
    rotations = compute_body_rotations(intervals, attitude, problem.model.step)
    phases: list[dict[str, Any]] = [
        {"name": phase.label, "from": phase.start, "to": phase.end} for phase in trajectory.phases
    ]
    phases += [{"name": SHADOW, "from": a, "to": b, "shaded": True} for a, b in shadow]
    field = environment.field[0] / np.linalg.norm(environment.field[0])
    axes = [
        _draw_arrow("xyz"[i], axis, i) | {"textposition": "top center"}
        for i, axis in enumerate(0.78 * np.eye(3))
    ]
    return {
        "data": [
            *_draw_sphere(),
            _draw_arrow("Sun", environment.sun[0], 4)
            | {"meta": {"rotation": "Sun", "faint": SHADOW}},
            _draw_arrow("magnetic field", field, 5, "field") | {"meta": {"rotation": "field"}},
            *(_place_in_space(trace, attitude[0]) for trace in (*_draw_box(), *axes)),
        ],
        "layout": {
            "title": build_title("Attitude in the inertial frame"),
            "scene": {
                **{f"{axis}axis": {"visible": False, "range": [-1.2, 1.2]} for axis in "xyz"},
                "aspectmode": "manual",
                "aspectratio": dict.fromkeys("xyz", 1.75),
                "camera": {
                    "eye": {"x": 1.05, "y": 0.75, "z": 0.5},
                    "projection": {"type": "orthographic"},
                },
                "dragmode": "orbit",
            },
            "height": 520,
            "margin": {"l": 0, "r": 0, "t": 40, "b": 0},
            "showlegend": False,
            "meta": {
                "motion": {
                    "end": float(intervals.times[-1]),
                    "rotations": {"body": rotations, **inertial},
                    "phases": phases,
                }
            },
        },
    }


def _build_rotations(times: Floats, vectors: Floats) -> dict[str, Floats]:
    return {"times": times, **dict(zip("xyz", np.degrees(vectors).T, strict=True))}


def _draw_sphere() -> list[dict[str, Any]]:
    around = np.radians(np.linspace(0.0, 360.0, 61))
    ring = np.column_stack([np.cos(around), np.sin(around), 0.0 * around])
    circles = np.vstack([[*np.roll(ring, i, axis=1), [np.nan] * 3] for i in range(3)])
    return [
        _draw_points(circles, mode="lines", line={"color": GRAY, "width": 2}, opacity=0.45),
        _draw_points(
            1.1 * np.eye(3), mode="text", text=list("XYZ"), textfont={"color": GRAY, "size": 13}
        ),
    ]


def _draw_arrow(name: str, tip: Floats, index: int, label: str | None = None) -> dict[str, Any]:
    color = COLORS[index]
    return _draw_points(
        np.vstack([0.0 * tip, tip]),
        name=name,
        mode="lines+markers+text",
        line={"color": color, "width": 6},
        marker={"color": color, "size": [0, 7], "line": {"width": 0}},
        text=["", label or name],
        textposition="bottom center",
        textfont={"color": color, "size": 16},
    )


def _draw_box() -> list[dict[str, Any]]:
    signs = np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)], dtype=float)
    corners = signs * _HALF_EDGES
    stroke = corners[[0, 1, 3, 2, 0, 4, 5, 1, 5, 7, 3, 7, 6, 2, 6, 4]]
    hull = {"type": "mesh3d", "alphahull": 0, "color": "#9aa7b4", "flatshading": True}
    return [
        _draw_points(corners, **hull),
        _draw_points(stroke, mode="lines", line={"color": "#4a5560", "width": 3}),
    ]


def _place_in_space(trace: dict[str, Any], start: Floats) -> dict[str, Any]:
    points = np.column_stack([trace[axis] for axis in "xyz"]) @ start
    return trace | dict(zip("xyz", points.T, strict=True)) | {"meta": {"rotation": "body"}}


def _draw_points(points: Floats, **style: Any) -> dict[str, Any]:
    x, y, z = points.T
    defaults = {"type": "scatter3d", "hoverinfo": "skip", "showlegend": False}
    return {**defaults, "x": x, "y": y, "z": z, **style}
