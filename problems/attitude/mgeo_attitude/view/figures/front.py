"""Figure of a front: attitude 1-sigma or trace against the convergence time."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
import plotly.graph_objects as go

from mgeo.evaluation.dominance import find_front_rows
from mgeo.figures.style import (
    COLORS,
    GRAY,
    HOVER_HINT,
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

#: Relative margin on both sides of the time axis.
_TIME_MARGIN = 0.04


class _Scale(NamedTuple):
    """Quantity that the vertical axis of the front shows: the trace or the attitude 1-sigma.

    `column` is its column in arrays of t_end, trace and attitude 1-sigma. `required` is the
    required value, infinite without a requirement.
    """

    name: str
    title: str
    column: int
    required: float = math.inf


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
    """Return a plotly figure with the attitude 1-sigma or the trace of each plan against its
    convergence time.

    Buttons select the 1-sigma [deg] or the trace. The hover text of a plan lists its maneuvers. The
    traces are the boundary of the dominated region; the plans, whose ``customdata`` is their
    number; the plans that do not converge; the boundary of the values that 9 of 10 Monte Carlo runs
    do not exceed; the lower bound; the requirement; and the knee. The time after the end of the
    window is shaded.

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
    hover = np.array(
        [
            _format_hover_text(solutions, i, scenario, monte_carlo_values[i])
            for i in range(len(values))
        ]
    )
    span = _compute_time_range(scenario, np.append(values[:, 0], monte_carlo_values[:, 0]))
    attitude = f"attitude 1-sigma, worst axis{format_nominal_suffix(scenario)} [deg]"
    scales = [
        _Scale("attitude", attitude, 2, scenario.required_sigma.get("attitude_deg", math.inf)),
        _Scale("trace", "trace of the covariance at t_end [-]", 1),
    ]
    knee = values[[] if knee_index is None else [knee_index]]
    groups = [
        ("plans", values[:, 0] < unconverged_t_end, COLORS[0], SYMBOLS[0]),
        ("not converged", values[:, 0] >= unconverged_t_end, GRAY, "x"),
    ]
    drawn = []
    for scale in scales:
        columns = [0, scale.column]
        traces = [
            _draw_dominated_boundary(
                values[:, columns], "boundary", {"width": 1, "color": "#b9c2cc"}
            )
        ]
        traces[0]["showlegend"] = False
        for name, group, color, symbol in groups:
            # An outline would hide the color of overlapping points.
            marker = {"color": color, "symbol": symbol, "size": 8, "opacity": 0.8}
            labels = {"customdata": solutions.numbers[group], "hovertext": hover[group]}
            points = _draw_points(values[group][:, columns], name) | {
                "marker": marker | {"line": {"width": 0}}
            }
            traces.append(points | labels | {"hoverinfo": "text"})
        drawn.append([*traces, *_draw_lines(scale, monte_carlo_values, lower_bound, knee, span)])
    state = ", none of which satisfies all constraints" if is_infeasible else ""
    figure = apply_style(
        go.Figure(drawn[0]),
        f"Calibration maneuvers: accuracy against {scenario.convergence.time_label}",
        f"scenario {escape_markup(scenario.name)}; {len(values)} plans{state}{HOVER_HINT}",
    )
    _mark_times(figure, scenario, span)
    figure.update_xaxes(title_text="t_end [s]", tickformat="d", range=span)
    axes = [
        build_log_axis_layout(np.concatenate([each["y"] for each in traces])) for traces in drawn
    ]
    figure.update_yaxes(axes[0], title_text=scales[0].title)
    return figure.update_layout(
        # Place the legend below the axis title, where it covers neither points nor labels.
        legend={
            "orientation": "h",
            "x": 1,
            "xanchor": "right",
            "y": 0,
            "yref": "container",
            "yanchor": "bottom",
        },
        hovermode="closest",
        margin={"t": 125, "b": 105},  # Leave room for buttons and the legend.
        updatemenus=[_build_buttons(scales, drawn, axes)],
    )


def _draw_lines(
    scale: _Scale, monte_carlo_values: Floats, lower_bound: Floats, knee: Floats, span: list[float]
) -> Iterator[dict[str, Any]]:
    columns = [0, scale.column]
    line = {"width": 1.5, "color": COLORS[2], "dash": "dot"}
    yield _draw_dominated_boundary(
        monte_carlo_values[:, columns], f"in {MONTE_CARLO_SHARE_TEXT}", line
    )
    yield {
        **_draw_line(lower_bound[:, columns], "lower bound", {"width": 1.5, "color": GRAY}),
        "hovertemplate": "lower bound %{y:.4g} after %{x:.6g} s<extra></extra>",
    }
    required = np.array([[time, scale.required] for time in span if scale.required < math.inf])
    line = {"width": 1.5, "color": COLORS[3], "dash": "dash"}
    yield _draw_line(required.reshape(-1, 2), f"required, {scale.required:.4g} deg", line)
    yield {
        **_draw_points(knee[:, columns], "knee"),
        "mode": "markers+text",
        "text": ["knee"] * len(knee),
        "textposition": "bottom left",
        "marker": {"symbol": "circle-open", "size": 16, "color": COLORS[6], "line": {"width": 2}},
        "hoverinfo": "skip",
        "showlegend": False,
    }


def _compute_time_range(scenario: Scenario, times: Floats) -> list[float]:
    first, last = float(np.nanmin(times)), float(np.nanmax(times))
    margin = _TIME_MARGIN * (last - first) or 0.05 * last
    if scenario.deadline < 3.0 * last:
        last = max(last, scenario.deadline)
    return [max(first - margin, 0.0), last + margin]


def _mark_times(figure: go.Figure, scenario: Scenario, span: list[float]) -> None:
    text = {"textangle": -90, "xanchor": "right", "yanchor": "top", "font": {"color": GRAY}}
    marks = ((scenario.orbit.period, "one orbital period"), (scenario.deadline, "window closes"))
    for time, name in marks:
        if span[0] < time < span[1]:
            line = {"color": GRAY, "width": 1.5, "dash": "dash"}
            figure.add_vline(x=time, line=line, annotation={"text": name, **text})
    if scenario.deadline < span[1]:
        shade = {"fillcolor": "rgba(128,128,128,0.2)", "line": {"width": 0}, "layer": "below"}
        figure.add_vrect(x0=scenario.deadline, x1=span[1], **shade)


def _build_buttons(
    scales: list[_Scale], drawn: list[list[dict[str, Any]]], axes: list[dict[str, Any]]
) -> dict[str, Any]:
    buttons = []
    for scale, traces, axis in zip(scales, drawn, axes, strict=True):
        changes = {key: [np.asarray(each[key]).tolist() for each in traces] for key in "xy"}
        changes["visible"] = [each["visible"] for each in traces]
        layout = {"yaxis.title.text": scale.title, "yaxis.dtick": axis.get("dtick")}
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


def _draw_dominated_boundary(points: Floats, name: str, line: dict[str, Any]) -> dict[str, Any]:
    trace = _draw_line(points[find_front_rows(points)], name, {"shape": "hv", **line})
    return {**trace, "hoverinfo": "skip"}


def _format_hover_text(
    solutions: PlottedSolutions, i: int, scenario: Scenario, monte_carlo_values: Floats
) -> str:
    t_end, trace = solutions.F[i]
    lines = [
        f"<b>{solutions.labels[i]}</b>",
        f"t_end {t_end:.6g} s ({t_end / scenario.orbit.period:.3f} orbits)",
        f"trace {trace:.4g}",
        f"attitude {solutions.sigma_deg[i]:.3g} deg (1-sigma, worst body axis)",
    ]
    if np.isfinite(monte_carlo_values).all():
        lines.append(
            f"in {MONTE_CARLO_SHARE_TEXT}: t_end {monte_carlo_values[0]:.6g} s, trace "
            f"{monte_carlo_values[1]:.4g}, attitude {monte_carlo_values[2]:.3g} deg"
        )
    lines.append("maneuvers, x / y / z [deg/s] for duration [s]:")
    lines += [f"{m}: {text}" for m, text in enumerate(format_maneuvers(solutions.X[i]), 1)]
    return "<br>".join(lines)
