"""Small figures of each single plan, for pages that show all plans of a front."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from mgeo.figures.style import COLORS, GRAY, LEGEND, build_log_axis_layout, escape_markup
from mgeo_attitude._typing import Floats
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.maneuvers.schedule import RateIntervals
from mgeo_attitude.problem import AttitudeManeuverProblem
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.sensors.suite import list_block_units
from mgeo_attitude.view.figures.attitude_animation import compute_sun_field_rotations, draw_attitude
from mgeo_attitude.view.figures.curves import (
    MAP_HALF_SIZE,
    draw_graticule,
    project_circle,
    project_directions,
    simplify_curves,
)
from mgeo_attitude.view.figures.style import build_line_style, build_small_layout
from mgeo_attitude.view.figures.time_series import select_sample_steps
from mgeo_attitude.view.plans import Plans
from mgeo_attitude.view.summaries import format_nominal_suffix

Intervals = list[tuple[float, float]]

#: Number of points of each curve, and of each path on the map of directions.
_N_SAMPLES, _N_DIRECTIONS = 48, 180
_ECLIPSE_COLOR = "rgba(128,128,128,0.22)"


def draw_plans(plans: Plans) -> Iterator[dict[str, dict[str, Any]]]:
    """Yield one dict of small plotly figures per plan, keyed by figure name.

    The figures show body rates, attitude in space, directions of Sun and field, trace and 1-sigmas.
    Each figure is a dict in plotly's JSON format. Eclipses are shaded. The dict of figures is empty
    for a plan whose covariance lost positivity.
    """
    problem = plans.problem
    eclipses, inertial = _list_eclipses(problem), compute_sun_field_rotations(problem.environment)
    for row, t_end in enumerate(plans.nominal.t_end.tolist()):
        if not np.isfinite(t_end):
            yield {}
            continue
        trajectory = plans.compute_trajectory(row)
        (variances,) = problem.evaluate_nominal(plans.X[[row]], history=True).variances
        rates = _draw_rates(problem, trajectory.intervals)
        errors = _draw_errors(problem, t_end, variances)
        _set_time_axis(rates["layout"], trajectory.intervals.times[-1], eclipses)
        for figure in errors.values():
            _set_time_axis(figure["layout"], t_end, eclipses)
        yield {
            "rates": rates,
            "motion": draw_attitude(problem, trajectory, inertial, eclipses),
            "directions": _draw_directions(problem, trajectory.attitude, t_end),
            **errors,
        }


def _set_time_axis(layout: dict[str, Any], t_end: float, eclipses: Intervals) -> None:
    layout["xaxis"] = {
        "title": {"text": "time [s]"},
        "range": [0.0, float(t_end)],
        "tickformat": "d",
    }
    band = {"type": "rect", "xref": "x", "yref": "paper", "y0": 0, "y1": 1, "layer": "below"}
    band |= {"fillcolor": _ECLIPSE_COLOR, "line": {"width": 0}}
    layout["shapes"] = [{**band, "x0": start, "x1": end} for start, end in eclipses]
    visible = [(start, min(end, t_end)) for start, end in eclipses if start < t_end]
    if visible:
        start, end = visible[0]
        is_left = start + end < t_end
        layout["annotations"] = [
            {
                "text": "eclipse",
                "font": {"size": 11},
                "showarrow": False,
                "x": start if is_left else end,
                "xanchor": "left" if is_left else "right",
                "y": 1.0,
                "yref": "paper",
                "yanchor": "bottom",
            }
        ]


def _draw_rates(problem: AttitudeManeuverProblem, intervals: RateIntervals) -> dict[str, Any]:
    model, limit = problem.model, problem.scenario.maneuvers.max_rate_deg_s
    times, rates = _build_rate_polyline(intervals, model)
    rows = simplify_curves(times, rates, _N_SAMPLES)
    lines = [_draw_line(times[rows], rates[rows, i], i) for i in range(3)]
    bound = {"showlegend": False, "hoverinfo": "skip", "name": "largest rate"}
    bound["line"] = {"color": GRAY, "dash": "dash", "width": 1}
    span = np.array([0.0, max(problem.scenario.duration, intervals.times[-1])])
    lines += [_draw_line(span, np.full(2, end), 0) | bound for end in (-limit, limit)]
    axis = {"title": {"text": "body rate [deg/s]"}, "range": [-1.15 * limit, 1.15 * limit]}
    return {"data": lines, "layout": _build_layout("Body rates", axis)}


def _build_rate_polyline(intervals: RateIntervals, model: FilterModel) -> tuple[Floats, Floats]:
    """Return the times [s] and body rates [deg/s] of a polyline through the rate profile.

    The intervals of a ramp, one step each, become a straight line through their midpoints.
    """
    starts, ends = intervals.times[:-1], intervals.times[1:]
    in_ramp = (ends - starts < 1.5 * model.step) & (model.slew_limits is not None)
    first = np.where(in_ramp, 0.5 * (starts + ends), starts)
    line = np.column_stack([first, np.where(in_ramp, np.nan, ends)]).ravel()
    is_point = ~np.isnan(line)
    return line[is_point], np.degrees(np.repeat(intervals.rates, 2, axis=0)[is_point])


def _draw_errors(
    problem: AttitudeManeuverProblem, t_end: float, variances: Floats
) -> dict[str, dict[str, Any]]:
    model = problem.model
    steps = select_sample_steps(round(t_end / model.step))
    trace, sigma = variances[steps] @ model.weights, np.sqrt(variances[steps])
    rows = simplify_curves(
        steps.astype(np.float64), np.log10(np.column_stack([trace, sigma])), _N_SAMPLES
    )
    times: Floats = steps[rows].astype(np.float64) * model.step
    trace, sigma = trace[rows], sigma[rows]
    suffix = format_nominal_suffix(problem.scenario)
    figures = {
        "trace": {
            "data": [_draw_line(times, trace, 0) | {"name": "trace", "showlegend": False}],
            "layout": _build_layout(
                f"Trace of the covariance{suffix}",
                {"title": {"text": "trace [-]"}, **build_log_axis_layout(trace)},
            ),
        }
    }
    for b, block in enumerate(list_block_units(model.suite)):
        block_sigma = sigma[:, 3 * b : 3 * b + 3] * block.factor
        figures[block.label] = {
            "data": [_draw_line(times, block_sigma[:, axis], axis) for axis in range(3)],
            "layout": _build_layout(
                f"{block.label[0].upper()}{block.label[1:]}, predicted 1-sigma{suffix}",
                {
                    "title": {"text": f"1-sigma [{block.unit}]"},
                    **build_log_axis_layout(block_sigma),
                },
            ),
        }
    return figures


def _draw_directions(
    problem: AttitudeManeuverProblem, attitude: Floats, t_end: float
) -> dict[str, Any]:
    environment = problem.environment
    last = round(t_end / problem.model.step)
    steps = np.rint(np.linspace(0, last, min(_N_DIRECTIONS, last + 1))).astype(np.int64)
    sunlit = steps[environment.sunlit[steps]] if problem.scenario.eclipse else steps
    traces = draw_graticule()
    for index, (name, inertial, visible_steps) in enumerate(
        (("Sun", environment.sun, sunlit), ("magnetic field", environment.field, steps))
    ):
        style = {"marker": {"color": COLORS[4 + index], "size": 4 + index * 0.5}}
        coordinates = project_directions(
            np.einsum("kij,kj->ki", attitude[visible_steps], inertial[visible_steps])
        )
        traces.append(_build_map_trace(name, *coordinates, mode="markers", **style))
    traces += _draw_cones(problem.scenario)
    width, height = MAP_HALF_SIZE
    hidden = {"visible": False, "fixedrange": True}
    axis = {**hidden, "range": [-height, height], "scaleanchor": "x"}
    layout = _build_layout("Directions in the body frame", axis)
    layout["xaxis"] = {**hidden, "range": [-width, width]}
    layout["margin"] |= {"l": 15, "t": 35, "b": 15}
    # The legend has a line for each cone and would cover the title if it were above the map.
    layout["legend"] = LEGEND
    return {"data": traces, "layout": layout}


def _draw_cones(scenario: Scenario) -> list[dict[str, Any]]:
    cones = [
        (escape_markup(constraint.label), constraint.build_cone(), "solid")
        for constraint in scenario.path_constraints
    ]
    for sensor in scenario.sensors:
        for cone in sensor.list_visibility_cones():
            name = (
                f"field of view of {sensor.name}"
                if cone.keep_in
                else f"{cone.direction.capitalize()} exclusion of {sensor.name}"
            )
            cones.append((name, cone, "dot" if cone.keep_in else "dash"))
    traces = []
    for index, (name, cone, dash) in enumerate(cones):
        style = {"line": {"color": COLORS[(1 + index) % 4], "dash": dash, "width": 1.5}}
        coordinates = project_circle(cone.axis, cone.half_angle)
        traces.append(_build_map_trace(name, *coordinates, mode="lines", **style))
    return traces


def _build_map_trace(name: str, across: Any, up: Any, **style: Any) -> dict[str, Any]:
    return {"type": "scatter", "name": name, "x": across, "y": up, "hoverinfo": "name", **style}


def _draw_line(times: Floats, values: Floats, index: int) -> dict[str, Any]:
    return {
        "type": "scatter",
        "name": "xyz"[index],
        "x": times,
        "y": values,
        "mode": "lines",
        "line": build_line_style(index),
        "hovertemplate": "%{x:.6g} s: %{y:.4g}",
    }


def _build_layout(text: str, axis: dict[str, Any]) -> dict[str, Any]:
    legend = {"orientation": "h", "x": 1, "xanchor": "right", "y": 1.02, "yanchor": "bottom"}
    return {
        **build_small_layout(text),
        "legend": {**legend, "title": {"text": "body axis", "side": "left"}},
        "yaxis": axis,
    }


def _list_eclipses(problem: AttitudeManeuverProblem) -> Intervals:
    if not problem.scenario.eclipse:
        return []
    times, dark = problem.environment.times, ~problem.environment.sunlit
    edges = np.flatnonzero(np.diff(np.concatenate([[False], dark, [False]])))
    intervals = np.append(times, times[-1])[edges].reshape(-1, 2)
    return [(start, end) for start, end in intervals.tolist()]
