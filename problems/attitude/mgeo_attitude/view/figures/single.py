"""Small figures of single plans for pages that show a whole front."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from mgeo.figures.style import COLORS, GRAY, build_log_axis_layout, escape_markup
from mgeo_attitude._typing import Floats
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.maneuvers.schedule import Flown
from mgeo_attitude.problem import AttitudeManeuverProblem
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.sensors.suite import block_units
from mgeo_attitude.view.describe import exactly
from mgeo_attitude.view.figures.against_time import sample_steps
from mgeo_attitude.view.figures.curves import OUTLINE, circle, corners, graticule, projected
from mgeo_attitude.view.figures.motion import directions, motion
from mgeo_attitude.view.figures.style import line, small_layout
from mgeo_attitude.view.plans import Plans

Intervals = list[tuple[float, float]]

#: Number of samples of each curve, and of each path on the body sphere.
_SAMPLES, _DIRECTIONS = 48, 180
_SHADOW = "rgba(128,128,128,0.22)"


def drawings(plans: Plans) -> Iterator[dict[str, dict[str, Any]]]:
    """Yield the figures of each plan: rates, directions of Sun and field, attitude, 1-sigmas.

    Eclipses are shaded. A plan whose covariance was lost yields an empty dictionary.
    """
    problem = plans.problem
    shadow, inertial = _shadow(problem), directions(problem.environment)
    for row, t_end in enumerate(plans.exactly.t_end.tolist()):
        if not np.isfinite(t_end):
            yield {}
            continue
        trajectory = plans.trajectory(row)
        (variances,) = problem.run(plans.X[[row]], history=True).variances
        rates = _rates(problem, trajectory.intervals)
        errors = _errors(problem, t_end, variances)
        _against_time(rates["layout"], trajectory.intervals.times[-1], shadow)
        for figure in errors.values():
            _against_time(figure["layout"], t_end, shadow)
        yield {
            "rates": rates,
            "motion": motion(problem, trajectory, inertial, shadow),
            "directions": _directions(problem, trajectory.attitude, t_end),
            **errors,
        }


def _against_time(layout: dict[str, Any], t_end: float, shadow: Intervals) -> None:
    layout["xaxis"] = {
        "title": {"text": "time [s]"},
        "range": [0.0, float(t_end)],
        "tickformat": "d",
    }
    band = {"type": "rect", "xref": "x", "yref": "paper", "y0": 0, "y1": 1, "layer": "below"}
    band |= {"fillcolor": _SHADOW, "line": {"width": 0}}
    layout["shapes"] = [{**band, "x0": start, "x1": end} for start, end in shadow]


def _rates(problem: AttitudeManeuverProblem, flight: Flown) -> dict[str, Any]:
    model, limit = problem.model, problem.scenario.maneuvers.max_rate_deg_s
    times, rates = _rate_polyline(flight, model)
    rows = corners(times, rates, _SAMPLES)
    lines = [_line(times[rows], rates[rows, i], i) for i in range(3)]
    bound = {"showlegend": False, "hoverinfo": "skip", "name": "limit"}
    bound["line"] = {"color": GRAY, "dash": "dash", "width": 1}
    span = np.array([0.0, max(problem.scenario.duration, flight.times[-1])])
    lines += [_line(span, np.full(2, end), 0) | bound for end in (-limit, limit)]
    axis = {"title": {"text": "deg/s"}, "range": [-1.15 * limit, 1.15 * limit]}
    return {"data": lines, "layout": _layout("Body rates", axis)}


def _rate_polyline(flight: Flown, model: FilterModel) -> tuple[Floats, Floats]:
    """Return the body rates as polylines: times [s] and rates [deg/s].

    The intervals of a ramp, one step each, are drawn as a straight line through their midpoints.
    """
    starts, ends = flight.times[:-1], flight.times[1:]
    in_ramp = (ends - starts < 1.5 * model.step) & (model.slew_limits is not None)
    first = np.where(in_ramp, 0.5 * (starts + ends), starts)
    line = np.column_stack([first, np.where(in_ramp, np.nan, ends)]).ravel()
    is_point = ~np.isnan(line)
    return line[is_point], np.degrees(np.repeat(flight.rates, 2, axis=0)[is_point])


def _errors(
    problem: AttitudeManeuverProblem, t_end: float, variances: Floats
) -> dict[str, dict[str, Any]]:
    """Return figures of the trace and of each state block, with a line for each axis."""
    model = problem.model
    steps = sample_steps(round(t_end / model.step))
    trace, sigma = variances[steps] @ model.weights, np.sqrt(variances[steps])
    rows = corners(steps.astype(np.float64), np.log10(np.column_stack([trace, sigma])), _SAMPLES)
    times: Floats = steps[rows].astype(np.float64) * model.step
    trace, sigma = trace[rows], sigma[rows]
    figures = {
        "trace": {
            "data": [_line(times, trace, 0) | {"name": "trace", "showlegend": False}],
            "layout": _layout("Trace of the covariance", build_log_axis_layout(trace)),
        }
    }
    for b, block in enumerate(block_units(model.suite)):
        own = sigma[:, 3 * b : 3 * b + 3] * block.factor
        unit = block.unit if block.unit != "-" else ""
        figures[block.label] = {
            "data": [_line(times, own[:, axis], axis) for axis in range(3)],
            "layout": _layout(
                f"{block.label}, 1-sigma{exactly(problem.scenario)}",
                {"title": {"text": unit}, **build_log_axis_layout(own)},
            ),
        }
    return figures


def _directions(problem: AttitudeManeuverProblem, body: Floats, t_end: float) -> dict[str, Any]:
    """Draw the directions of Sun and field in body axes on an equal-area map."""
    environment = problem.environment
    last = round(t_end / problem.model.step)
    steps = np.rint(np.linspace(0, last, min(_DIRECTIONS, last + 1))).astype(np.int64)
    seen = steps[environment.sunlit[steps]] if problem.scenario.eclipse else steps
    traces = graticule()
    for index, (name, inertial, at) in enumerate(
        (("Sun", environment.sun, seen), ("field", environment.field, steps))
    ):
        look = {"marker": {"color": COLORS[4 + index], "size": 4 + index * 0.5}}
        place = projected(np.einsum("kij,kj->ki", body[at], inertial[at]))
        traces.append(_on_map(name, *place, mode="markers", **look))
    traces += _edges(problem.scenario)
    width, height = OUTLINE
    hidden = {"visible": False, "fixedrange": True}
    axis = {**hidden, "range": [-height, height], "scaleanchor": "x"}
    layout = _layout("Sun and field seen from the body", axis)
    layout["xaxis"] = {**hidden, "range": [-width, width]}
    layout["margin"] |= {"l": 15, "t": 35, "b": 15}
    # The legend has a line for each cone and would cover the title if it were above the map.
    layout["legend"] |= {"x": 0.5, "xanchor": "center", "y": -0.02, "yanchor": "top"}
    return {"data": traces, "layout": layout}


def _edges(scenario: Scenario) -> list[dict[str, Any]]:
    """Draw the cones of path constraints (solid) and of sensors (dotted or dashed) on the map."""
    cones = [(escape_markup(limit.label), limit.cone(), "solid") for limit in scenario.path_limits]
    for sensor in scenario.sensors:
        for view in sensor.views():
            seen = "view of" if view.keep_in else f"{view.direction.capitalize()} off"
            cones.append((f"{seen} {sensor.name}", view, "dot" if view.keep_in else "dash"))
    traces = []
    for index, (name, cone, dash) in enumerate(cones):
        look = {"line": {"color": COLORS[(1 + index) % 4], "dash": dash, "width": 1.5}}
        place = circle(cone.axis, cone.half_angle)
        traces.append(_on_map(name, *place, mode="lines", **look))
    return traces


def _on_map(name: str, across: Any, up: Any, **look: Any) -> dict[str, Any]:
    return {"type": "scatter", "name": name, "x": across, "y": up, "hoverinfo": "name", **look}


def _line(times: Floats, values: Floats, index: int) -> dict[str, Any]:
    return {
        "type": "scatter",
        "name": "xyz"[index],
        "x": times,
        "y": values,
        "mode": "lines",
        "line": line(index),
        "hovertemplate": "%{x:.6g} s: %{y:.4g}",
    }


def _layout(text: str, axis: dict[str, Any]) -> dict[str, Any]:
    return {
        **small_layout(text),
        "legend": {"orientation": "h", "x": 1, "xanchor": "right", "y": 1.02, "yanchor": "bottom"},
        "yaxis": axis,
    }


def _shadow(problem: AttitudeManeuverProblem) -> Intervals:
    """Return start and end [s] of each eclipse of the run."""
    if not problem.scenario.eclipse:
        return []
    times, dark = problem.environment.times, ~problem.environment.sunlit
    edges = np.flatnonzero(np.diff(np.concatenate([[False], dark, [False]])))
    intervals = np.append(times, times[-1])[edges].reshape(-1, 2)
    return [(start, end) for start, end in intervals.tolist()]
