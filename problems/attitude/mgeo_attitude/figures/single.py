"""Figures of one plan each, small enough that a page can hold those of a whole front."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
import plotly.graph_objects as go
from numpy.typing import NDArray

from mgeo.figures.style import COLORS, GRAY, log_axis

from ..describe import BlockUnit, block_units, checked_designs
from ..filter.evaluator import evaluate
from ..filter.model import agility
from ..filter.reference import attitudes
from .convergence import sample_steps
from .maneuvers import timeline
from .motion import directions, motion
from .polyline import corners
from .sphere import OUTLINE, graticule, projected
from .style import line, title

if TYPE_CHECKING:
    from ..problem import AttitudeManeuverProblem

Floats = NDArray[np.float64]

#: Samples of each curve, and of each path on the body sphere.
_SAMPLES, _DIRECTIONS = 48, 200
#: Floats that the histories of one chunk of designs may take: 64 MB.
_CHUNK_FLOATS = 2**23
_SHADOW = "rgba(128,128,128,0.22)"


def solution_figures(problem: AttitudeManeuverProblem, X: Floats) -> Iterator[dict[str, go.Figure]]:
    """For each design, shape (n, n_var): rates, directions of Sun and field, attitude, 1-sigmas.

    Times in the Earth's shadow are shaded. A design whose covariance broke down has no figures.

    Raises
    ------
    ValueError
        If `X` has another number of columns.
    """
    designs = checked_designs(problem, X)
    model = problem.model
    shadow = _shadow(problem)
    shades = [_shade(*interval) for interval in shadow]
    inertial = directions(problem.environment)
    size = max(1, _CHUNK_FLOATS // ((model.n_steps + 1) * model.suite.n_states))
    for start in range(0, len(designs), size):
        chunk = np.ascontiguousarray(designs[start : start + size])
        result = evaluate(model, chunk, problem.threads, history=True)
        for x, t_end, variances in zip(chunk, result.t_end, result.variances, strict=True):
            if not np.isfinite(t_end):
                yield {}
                continue
            plan = model.schedule(x)
            body = attitudes(plan.rates[0], plan.starts[0], model.n_steps, model.step)
            against_time = {
                "rates": _rates(problem, x, t_end),
                **_errors(problem, t_end, variances),
            }
            for figure in against_time.values():
                figure["layout"]["shapes"] = shades
                figure["layout"]["xaxis"] = _time_axis(t_end)
            figures = {
                "rates": against_time.pop("rates"),
                "motion": motion(problem, x, t_end, body, inertial, shadow),
                "directions": _directions(problem, body, t_end),
                **against_time,
            }
            yield {name: go.Figure(figure, _validate=False) for name, figure in figures.items()}


def _rates(problem: AttitudeManeuverProblem, x: Floats, t_end: float) -> dict[str, Any]:
    times, rates, _ = timeline(x, t_end, problem.scenario)
    limit = problem.scenario.maneuvers.max_rate_deg_s
    ramp_step = 0.0 if agility(problem.scenario) is None else problem.model.step
    times, rates = _drawn(times, rates[:-1], ramp_step)
    rows = corners(times, rates, _SAMPLES)
    lines = [_line(times[rows], rates[rows, i], i) for i in range(3)]
    for sign in (-1.0, 1.0):
        ends = np.array([0.0, problem.scenario.duration])
        bound = _line(ends, np.full(2, sign * limit), 0, name="limit")
        bound["line"] = {"color": GRAY, "dash": "dash", "width": 1}
        lines.append(bound | {"showlegend": False, "hoverinfo": "skip"})
    axis = {"title": {"text": "deg/s"}, "range": [-1.15 * limit, 1.15 * limit]}
    return {"data": lines, "layout": _layout("Body rates", axis)}


def _drawn(times: Floats, rates: Floats, ramp_step: float) -> tuple[Floats, Floats]:
    """Stretches of constant rate between `times` as a line: level, then up or down.

    Those of a ramp, `ramp_step` [s] long, are drawn as the straight line through their middles.
    """
    starts, ends = times[:-1], times[1:]
    in_ramp = ends - starts < 1.5 * ramp_step
    middles = 0.5 * (starts + ends)
    pairs = np.column_stack([np.where(in_ramp, middles, starts), np.where(in_ramp, np.nan, ends)])
    line = pairs.ravel()
    kept = ~np.isnan(line)
    return line[kept], np.repeat(rates, 2, axis=0)[kept]


def _errors(
    problem: AttitudeManeuverProblem, t_end: float, variances: Floats
) -> dict[str, dict[str, Any]]:
    """Trace, and one figure for each 3-vector of the state with a line for each axis."""
    model = problem.model
    steps = sample_steps(round(t_end / model.step))
    trace, sigma = variances[steps] @ model.weights, np.sqrt(variances[steps])
    rows = corners(steps.astype(np.float64), np.log10(np.column_stack([trace, sigma])), _SAMPLES)
    times: Floats = steps[rows].astype(np.float64) * model.step
    trace, sigma = trace[rows], sigma[rows]
    figures = {
        "trace": {
            "data": [_line(times, trace, 0, name="trace", showlegend=False)],
            "layout": _layout("Trace of the covariance", _log_axis("-", trace)),
        }
    }
    for b, block in enumerate(block_units(model.suite)):
        figures[block.label] = _block(block, times, sigma[:, 3 * b : 3 * b + 3] * block.factor)
    return figures


def _block(block: BlockUnit, times: Floats, sigma: Floats) -> dict[str, Any]:
    lines = [_line(times, sigma[:, axis], axis) for axis in range(3)]
    return {
        "data": lines,
        "layout": _layout(f"{block.label}, 1-sigma", _log_axis(block.unit, sigma)),
    }


def _directions(problem: AttitudeManeuverProblem, body: Floats, t_end: float) -> dict[str, Any]:
    """Where Sun and field stand as seen from the body, at even times: an equal-area map."""
    environment = problem.environment
    last = round(t_end / problem.model.step)
    steps = np.rint(np.linspace(0, last, min(_DIRECTIONS, last + 1))).astype(np.int64)
    traces: list[dict[str, Any]] = [*graticule()]
    vectors = {"Sun": environment.sun, "field": environment.field}
    for index, (name, inertial) in enumerate(vectors.items()):
        at = np.einsum("kij,kj->ki", body[steps], inertial[steps])
        if name == "Sun" and problem.scenario.eclipse:
            at = np.where(environment.sunlit[steps, None], at, np.nan)
        across, up = projected(at)
        traces.append(
            {
                "type": "scatter",
                "name": name,
                "x": across,
                "y": up,
                "mode": "markers",
                "marker": {"color": (COLORS[4], COLORS[5])[index], "size": 4 + index * 0.5},
                "hoverinfo": "name",
            }
        )
    width, height = OUTLINE
    hidden = {"visible": False, "fixedrange": True}
    layout = _layout("Sun and field seen from the body", {**hidden, "range": [-height, height]})
    layout["yaxis"] |= {"scaleanchor": "x"}
    layout["xaxis"] = {**hidden, "range": [-width, width]}
    layout["margin"] |= {"l": 15, "b": 15}
    return {"data": traces, "layout": layout}


def _line(times: Floats, values: Floats, index: int, **more: Any) -> dict[str, Any]:
    return {
        "type": "scatter",
        "name": "xyz"[index],
        "x": times,
        "y": values,
        "mode": "lines",
        "line": line(index),
        "hovertemplate": "%{x:.6g} s: %{y:.4g}",
        **more,
    }


def _layout(text: str, axis: dict[str, Any]) -> dict[str, Any]:
    return {
        "title": title(text),
        "height": 300,
        "margin": {"l": 65, "r": 10, "t": 55, "b": 45},
        "legend": {"orientation": "h", "x": 1, "xanchor": "right", "y": 1.02, "yanchor": "bottom"},
        "yaxis": axis,
    }


def _time_axis(t_end: float) -> dict[str, Any]:
    return {"title": {"text": "time [s]"}, "range": [0.0, float(t_end)], "tickformat": "d"}


def _log_axis(unit: str, values: Floats) -> dict[str, Any]:
    return {
        "title": {"text": unit if unit != "-" else ""},
        **log_axis(values),
    }


def _shadow(problem: AttitudeManeuverProblem) -> list[tuple[float, float]]:
    """Starts and ends [s] of the times in the Earth's shadow, the same for all plans."""
    if not problem.scenario.eclipse:
        return []
    times, dark = problem.environment.times, ~problem.environment.sunlit
    edges = np.diff(np.concatenate([[False], dark, [False]]).astype(np.int8))
    ends = np.append(times, times[-1])
    starts, stops = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)
    return [(float(ends[a]), float(ends[b])) for a, b in zip(starts, stops, strict=True)]


def _shade(start: float, end: float) -> dict[str, Any]:
    return {
        "type": "rect",
        "xref": "x",
        "yref": "paper",
        "x0": start,
        "x1": end,
        "y0": 0,
        "y1": 1,
        "fillcolor": _SHADOW,
        "line": {"width": 0},
        "layer": "below",
    }
