"""Figure of a front: attitude accuracy or trace against the convergence time."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
import plotly.graph_objects as go

from mgeo._text import format_duration, format_two_digits
from mgeo.evaluation.dominance import find_front_rows
from mgeo.figures.front import needs_log_axis
from mgeo.figures.style import (
    COLORS,
    GRAY,
    HOVER_HINT,
    LOWER_BOUND_COLOR,
    MONTE_CARLO_COLOR,
    PREDICTION_COLOR,
    REQUIREMENT_COLOR,
    SYMBOLS,
    apply_style,
    build_log_axis_layout,
    escape_markup,
)
from mgeo_attitude._typing import Floats
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.view.figures.style import PlottedSolutions
from mgeo_attitude.view.plans import MONTE_CARLO_SHARE_TEXT
from mgeo_attitude.view.summaries import format_maneuvers, format_nominal_suffix

#: Relative margin on both sides of an axis.
_MARGIN = 0.05
#: Position of the label of the lower bound along the time axis.
_LABEL_POSITION = 0.5
_MINUTE = 60.0


class _Scale(NamedTuple):
    """Quantity on the vertical axis: attitude accuracy or trace of the covariance.

    `column` is its column in arrays of t_end, trace and attitude 1-sigma. `required` is the
    required value, infinite without a requirement.
    """

    name: str
    title: str
    column: int
    required: float = math.inf


class _Axis(NamedTuple):
    """Linear or logarithmic plotly axis with its range."""

    is_log: bool
    low: float
    high: float

    @classmethod
    def from_values(cls, values: Floats, is_log: bool) -> _Axis:
        low, high = np.nanmin(values), np.nanmax(values)
        if is_log:
            low, high = np.log10([low, high])
        margin = _MARGIN * (high - low) or _MARGIN * abs(high)
        return cls(is_log, low - margin, high + margin)

    @property
    def range(self) -> list[float]:
        return [self.low, self.high]

    def locate(self, value: float) -> float:
        """Return the relative position of a value along the axis, from 0 to 1."""
        position = math.log10(value) if self.is_log else value
        return (position - self.low) / (self.high - self.low)


def draw_front(
    scenario: Scenario,
    solutions: PlottedSolutions,
    monte_carlo_values: Floats,
    *,
    unconverged_t_end: float,
    is_infeasible: bool,
    lower_bound: Floats,
    knee_index: int | None,
) -> go.Figure:
    """Draw the attitude accuracy or the trace of each plan against its convergence time.

    Buttons select the attitude 1-sigma [deg] or the trace. The hover text of a plan lists its
    maneuvers. The figure also shows the boundary of the dominated region, the lower bound, the
    values that 90 % of Monte Carlo runs do not exceed, the required accuracy, and labels of the
    min-time, knee and min-trace plans. The time after the end of the window is shaded.

    Parameters
    ----------
    scenario : Scenario
    solutions : PlottedSolutions
    monte_carlo_values : array, shape (n, 3)
        0.9-quantiles of t_end [s], trace and attitude 1-sigma [deg] over Monte Carlo runs; NaN if
        they were not evaluated or if too few runs converge.
    unconverged_t_end : float
        t_end of a run that does not converge [s].
    is_infeasible : bool
        Whether all solutions are infeasible.
    lower_bound : array, shape (m, 3)
        Times [s], and lower bounds of trace and attitude 1-sigma [deg].
    knee_index : int or None
        Index of the knee among the solutions; None without a knee.

    Returns
    -------
    plotly Figure
    """
    values = np.column_stack([solutions.F, solutions.sigma_deg])
    roles = solutions.find_roles(knee_index)
    is_converged = values[:, 0] < unconverged_t_end
    verb, time_name = (
        ("ends", "maneuver time")
        if scenario.convergence.rule == "end"
        else ("converges", "convergence time")
    )
    hover = [
        _format_hover_text(
            solutions.format_label(i, roles),
            verb if is_converged[i] else "does not converge; ends",
            solutions.X[i],
            scenario,
            values[i],
            monte_carlo_values[i],
        )
        for i in range(len(values))
    ]
    values, monte_carlo_values, lower_bound = (
        array / [_MINUTE, 1.0, 1.0] for array in (values, monte_carlo_values, lower_bound)
    )
    time_axis = _build_time_axis(scenario, np.append(values[:, 0], monte_carlo_values[:, 0]))
    attitude = f"attitude accuracy{format_nominal_suffix(scenario)} [deg]"
    scales = [
        _Scale("attitude", attitude, 2, scenario.required_sigma.get("attitude_deg", math.inf)),
        _Scale("trace", f"trace of the covariance{format_nominal_suffix(scenario)} [-]", 1),
    ]
    drawn = [
        [
            *_draw_boundary(values[:, [0, scale.column]]),
            *_draw_lower_bound(lower_bound[:, [0, scale.column]], time_axis),
            *_draw_plans(scale, solutions, values, hover, is_converged),
            *_draw_monte_carlo(scale, solutions, verb, values, monte_carlo_values),
            *_draw_requirement(scale, time_axis),
            *_draw_labels(values[:, [0, scale.column]], roles, time_axis),
        ]
        for scale in scales
    ]
    axes = [_build_value_axis(traces) for traces in drawn]
    state = ", none of which satisfies all constraints" if is_infeasible else ""
    figure = apply_style(
        go.Figure(drawn[0]),
        f"Attitude accuracy against {time_name}",
        f"1-sigma of the worst body axis; scenario {escape_markup(scenario.name)}, {len(values)} "
        f"plans{state}{HOVER_HINT}",
    )
    _mark_times(figure, scenario, time_axis)
    layout = build_log_axis_layout(10.0 ** np.array(time_axis.range)) if time_axis.is_log else {}
    figure.update_xaxes(
        layout,
        title_text=f"{time_name} [min]",
        range=time_axis.range,
    )
    figure.update_yaxes(axes[0], title_text=scales[0].title)
    return figure.update_layout(
        hovermode="closest",
        margin={"t": 125},  # Leave room for the buttons.
        updatemenus=[_build_buttons(scales, drawn, axes)],
    )


def _draw_boundary(points: Floats) -> Iterator[dict[str, Any]]:
    line = {"width": 1, "color": "#b9c2cc", "shape": "hv"}
    trace = _draw_line(points[find_front_rows(points)], "boundary", line)
    yield trace | {"showlegend": False, "hoverinfo": "skip"}


def _draw_lower_bound(curve: Floats, time_axis: _Axis) -> Iterator[dict[str, Any]]:
    line = _draw_line(curve, "lower bound", {"width": 2, "color": LOWER_BOUND_COLOR})
    template = "lower bound %{y:.3g} after %{x:.3g} min<extra></extra>"
    yield line | {"hovertemplate": template, "showlegend": False}
    distances = [abs(time_axis.locate(time) - _LABEL_POSITION) for time in curve[:, 0]]
    nearest = [int(np.argmin(distances))] if distances else []
    yield _draw_texts(curve[nearest], ["lower bound"], ["bottom left"], LOWER_BOUND_COLOR)


def _draw_monte_carlo(
    scale: _Scale,
    solutions: PlottedSolutions,
    verb: str,
    values: Floats,
    monte_carlo_values: Floats,
) -> Iterator[dict[str, Any]]:
    columns = [0, scale.column]
    rows = np.flatnonzero(np.isfinite(monte_carlo_values).all(axis=1))
    gaps = np.full((len(rows), 2), np.nan)
    pairs = np.stack([values[rows][:, columns], monte_carlo_values[rows][:, columns], gaps], axis=1)
    line = {"width": 1, "color": MONTE_CARLO_COLOR}
    connections = _draw_line(pairs.reshape(-1, 2), "to the plan", line)
    yield connections | {"showlegend": False, "hoverinfo": "skip", "opacity": 0.5}
    hover = [
        f"<b>plan {solutions.numbers[row]}, {MONTE_CARLO_SHARE_TEXT}</b><br>"
        f"{verb} after {format_duration(monte_carlo_values[row, 0] * _MINUTE)}<br>"
        f"attitude {format_two_digits(monte_carlo_values[row, 2])} deg, "
        f"trace {monte_carlo_values[row, 1]:.3g}"
        for row in rows
    ]
    marks = _draw_points(monte_carlo_values[rows][:, columns], MONTE_CARLO_SHARE_TEXT)
    symbol = {
        "color": MONTE_CARLO_COLOR,
        "symbol": "diamond-open",
        "size": 6,
        "line": {"width": 1.5},
    }
    yield marks | {"marker": symbol, "hovertext": hover, "hoverinfo": "text"}


def _draw_plans(
    scale: _Scale,
    solutions: PlottedSolutions,
    values: Floats,
    hover: Sequence[str],
    is_converged: Any,
) -> Iterator[dict[str, Any]]:
    for name, group, color, symbol in (
        ("plans", is_converged, PREDICTION_COLOR, SYMBOLS[0]),
        ("not converged", ~is_converged, GRAY, "x"),
    ):
        # An outline would hide the color of overlapping points.
        look = {"color": color, "symbol": symbol, "size": 7, "opacity": 0.8, "line": {"width": 0}}
        points = _draw_points(values[group][:, [0, scale.column]], name) | {"marker": look}
        labels = {"customdata": solutions.numbers[group], "hovertext": np.array(hover)[group]}
        yield points | labels | {"hoverinfo": "text"}


def _draw_requirement(scale: _Scale, time_axis: _Axis) -> Iterator[dict[str, Any]]:
    ends = 10.0 ** np.array(time_axis.range) if time_axis.is_log else np.array(time_axis.range)
    points = np.array([[time, scale.required] for time in ends if scale.required < math.inf])
    line = {"width": 1.5, "color": REQUIREMENT_COLOR, "dash": "dash"}
    yield _draw_line(points.reshape(-1, 2), f"required accuracy, {scale.required:.4g} deg", line)


def _draw_labels(
    points: Floats, roles: dict[int, str], time_axis: _Axis
) -> Iterator[dict[str, Any]]:
    """Draw a ring and a name at each plan that has a role, such as the knee."""
    rows = list(roles)
    # Below the front, labels cover no points; the first plan has no points to its upper right.
    sides = ["left" if time_axis.locate(points[row, 0]) > 0.6 else "right" for row in rows]
    positions = [
        "bottom left" if roles[row] == "knee" else f"{_select_height(roles[row])} {side}"
        for row, side in zip(rows, sides, strict=True)
    ]
    ring = {"symbol": "circle-open", "size": 13, "color": COLORS[6], "line": {"width": 2}}
    texts = _draw_texts(points[rows], [roles[row] for row in rows], positions, COLORS[6])
    yield texts | {"mode": "markers+text", "marker": ring}


def _select_height(role: str) -> str:
    return "top" if role.startswith("min-time") else "bottom"


def _draw_texts(
    points: Floats, texts: list[str], positions: list[str], color: str
) -> dict[str, Any]:
    style = {"text": texts, "textposition": positions, "textfont": {"color": color, "size": 13}}
    quiet = {"mode": "text", "hoverinfo": "skip", "showlegend": False, "cliponaxis": False}
    return _draw_points(points, "labels") | style | quiet


def _build_time_axis(scenario: Scenario, times: Floats) -> _Axis:
    """Return the time axis [min], which includes the end of the window if it is close."""
    times = times[~np.isnan(times)]
    is_log, deadline = needs_log_axis(times), scenario.deadline / _MINUTE
    if deadline < 3.0 * times.max():
        times = np.append(times, deadline)
    return _Axis.from_values(times, is_log)


def _build_value_axis(traces: list[dict[str, Any]]) -> dict[str, Any]:
    values = np.concatenate([trace["y"] for trace in traces])
    values = values[np.isfinite(values)]
    axis = _Axis.from_values(values, is_log=True)
    # Labels are above the first plan and below the lower bound.
    room = 0.06 * (axis.high - axis.low)
    return build_log_axis_layout(values) | {"range": [axis.low - room, axis.high + room]}


def _mark_times(figure: go.Figure, scenario: Scenario, time_axis: _Axis) -> None:
    """Mark the orbital period and the end of the window, and shade the time after the window."""
    marks = ((scenario.orbit.period, "one orbital period"), (scenario.deadline, "window closes"))
    for time, name in marks:
        position = time_axis.locate(time / _MINUTE) if time < math.inf else math.inf
        if not 0.0 < position < 1.0:
            continue
        x = {"xref": "x domain", "yref": "paper"}
        line = {"color": GRAY, "width": 1.5, "dash": "dash"}
        figure.add_shape(type="line", x0=position, x1=position, y0=0, y1=1, line=line, **x)
        text = {"textangle": -90, "xanchor": "right", "yanchor": "top", "showarrow": False}
        figure.add_annotation(text=name, x=position, y=1, font={"color": GRAY}, **text, **x)
        if time == scenario.deadline:
            shade = {"fillcolor": "rgba(128,128,128,0.2)", "line": {"width": 0}, "layer": "below"}
            figure.add_shape(type="rect", x0=position, x1=1, y0=0, y1=1, **shade, **x)


def _build_buttons(
    scales: list[_Scale], drawn: list[list[dict[str, Any]]], axes: list[dict[str, Any]]
) -> dict[str, Any]:
    buttons = []
    for scale, traces, axis in zip(scales, drawn, axes, strict=True):
        changes = {key: [np.asarray(each[key]).tolist() for each in traces] for key in "xy"}
        changes["visible"] = [each["visible"] for each in traces]
        layout = {f"yaxis.{key}": value for key, value in ({"dtick": None} | axis).items()}
        layout["yaxis.title.text"] = scale.title
        buttons.append({"label": scale.name, "method": "update", "args": [changes, layout]})
    return {
        "type": "buttons",
        "direction": "right",
        "buttons": buttons,
        "x": 0,
        "xanchor": "left",
        "y": 1,
        "yanchor": "bottom",
        "pad": {"b": 8},
        "font": {"size": 12},
    }


def _draw_points(points: Floats, name: str) -> dict[str, Any]:
    trace = {"type": "scatter", "mode": "markers", "name": name, "visible": bool(len(points))}
    return {**trace, "x": points[:, 0], "y": points[:, 1]}


def _draw_line(points: Floats, name: str, line: dict[str, Any]) -> dict[str, Any]:
    return _draw_points(points, name) | {"mode": "lines", "line": line}


def _format_hover_text(
    label: str,
    verb: str,
    x: Floats,
    scenario: Scenario,
    values: Floats,
    monte_carlo_values: Floats,
) -> str:
    t_end, trace, sigma_deg = values
    lines = [
        f"<b>{label}</b>",
        f"{verb} after {format_duration(t_end)} ({t_end / scenario.orbit.period:.2f} orbits)",
        f"attitude {format_two_digits(sigma_deg)} deg (1-sigma, worst body axis)",
        f"trace {trace:.3g}",
    ]
    if np.isfinite(monte_carlo_values).all():
        lines.append(
            f"{MONTE_CARLO_SHARE_TEXT}: {format_duration(monte_carlo_values[0])}, attitude "
            f"{format_two_digits(monte_carlo_values[2])} deg, trace {monte_carlo_values[1]:.3g}"
        )
    lines.append("maneuvers: body rates x / y / z [deg/s] for duration [s]")
    lines += [f"{m}: {text}" for m, text in enumerate(format_maneuvers(x), 1)]
    return "<br>".join(lines)
