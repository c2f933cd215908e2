"""Figures of a front of sensor suites, and of single designs."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go
from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.criteria.objectives import attitude_accuracy_deg
from mgeo_attitude.filter.evaluator import Evaluation
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.view.figures.style import build_line_style, build_small_layout
from mgeo_attitude.view.summaries import format_maneuvers

from mgeo.figures.style import COLORS, SYMBOLS, apply_style, build_log_axis_layout, escape_markup
from mgeo_suite.catalog import NONE
from mgeo_suite.suites import SuiteModels

_N_SAMPLES = 200  # maximum number of points of a time history


def draw_figures(
    suites: SuiteModels, choices: Ints, maneuvers: Floats, price: Floats, result: Evaluation
) -> dict[str, go.Figure]:
    """Draw two figures of a front: accuracy versus price, and the selected sensors.

    The keys of the figures are "front" and "sensors". In the figure "front", the color indicates
    the star tracker. The number of a solution is its row index. Designs for which the covariance of
    the filter lost its positive definiteness are left out.

    Parameters
    ----------
    suites : SuiteModels
        Filter models of the suites.
    choices : array, shape (n, n_places)
        Index of the selected option of each mounting place.
    maneuvers : array, shape (n, 4 n_maneuvers)
        Body rates [deg/s] and duration [s] of each maneuver.
    price : array, shape (n,)
        Price of each suite [kEUR].
    result : Evaluation
        Results of the Kalman filter for the designs.
    """
    accuracy = attitude_accuracy_deg(result.covariance)
    rows = np.flatnonzero(np.isfinite(result.t_end) & np.isfinite(accuracy))
    order = rows[np.argsort(price[rows], kind="stable")]
    return {
        "front": _draw_front(suites, choices, maneuvers, price, accuracy, result, order),
        "sensors": _draw_sensors(suites, choices, price, order),
    }


def _draw_front(
    suites: SuiteModels,
    choices: Ints,
    maneuvers: Floats,
    price: Floats,
    accuracy: Floats,
    result: Evaluation,
    order: Ints,
) -> go.Figure:
    figure = go.Figure()
    names = [suites.get_option_names(choice) for choice in choices]
    trackers = [options.get("star tracker", NONE) for options in names]
    for k, tracker in enumerate(dict.fromkeys(trackers[row] for row in order)):
        rows = [int(row) for row in order if trackers[row] == tracker]
        hover = [
            "<br>".join(
                [
                    f"<b>solution {row}</b>",
                    f"{price[row]:.4g} kEUR, attitude {accuracy[row]:.3g} deg after "
                    f"{result.t_end[row]:.6g} s",
                    *map(escape_markup, suites.describe_suite(choices[row]).split(", ")),
                    "maneuvers, x / y / z [deg/s] for duration [s]:",
                    *format_maneuvers(maneuvers[row]),
                ]
            )
            for row in rows
        ]
        figure.add_scatter(
            name="no star tracker" if tracker == NONE else escape_markup(f"{tracker} star tracker"),
            x=price[rows],
            y=accuracy[rows],
            mode="markers",
            marker={"color": COLORS[k % 7], "symbol": SYMBOLS[k % 7], "size": 8},
            customdata=np.array(rows, dtype=np.int64),
            hovertext=hover,
            hoverinfo="text",
        )
    apply_style(
        figure,
        "Price and attitude accuracy of sensor suites",
        "each point is a suite with its plan; 1-sigma about the worst axis",
    )
    figure.update_xaxes(title="price [kEUR]")
    axis = build_log_axis_layout(accuracy[order]) if len(order) else {}
    figure.update_yaxes(title="attitude accuracy [deg]", **axis)
    return figure


def _draw_sensors(suites: SuiteModels, choices: Ints, price: Floats, order: Ints) -> go.Figure:
    """Draw the selected grades as a heatmap of mounting places and solutions."""
    places = suites.places[::-1]
    numbers = choices[order][:, ::-1].T
    texts = [
        [escape_markup(place.options[n]) for n in row]
        for place, row in zip(places, numbers, strict=True)
    ]
    shades = [n / max(len(p.options) - 1, 1) for p, n in zip(places, numbers, strict=True)]
    labels = [f"{row}: {price[row]:.4g} kEUR" for row in order]
    figure = go.Figure().add_heatmap(
        z=np.array(shades).reshape(len(places), len(order)),
        x=np.arange(len(order)),
        y=[place.name for place in places],
        text=texts,
        customdata=np.tile(labels, (len(places), 1)),
        hovertemplate="solution %{customdata}<br>%{y}: %{text}<extra></extra>",
        colorscale=[[0.0, "#f4f6f8"], [1.0, COLORS[0]]],
        zmin=0.0,
        zmax=1.0,
        showscale=False,
    )
    apply_style(figure, "Selected sensors of each suite", "darker: higher grade")
    figure.update_xaxes(title="suites in ascending order of price")
    return figure


def draw_solution_figures(model: FilterModel, result: Evaluation) -> dict[str, go.Figure]:
    """Draw two figures of a plan: body rates and attitude 1-sigma versus time.

    The keys of the figures are "rates" and "attitude".

    Parameters
    ----------
    model : FilterModel
        Filter model of any suite; only its time step is used.
    result : Evaluation
        Results of the Kalman filter for a single design, with their history.
    """
    t_end = result.t_end[0]
    end = round(t_end / model.step) if np.isfinite(t_end) else 0
    steps = np.unique(np.linspace(0, end, _N_SAMPLES).round().astype(np.int64))
    sigma = np.degrees(np.sqrt(result.variances[0, steps, :3].max(axis=1)))
    plan, times = result.plan, model.step * steps.astype(np.float64)
    maneuver = np.maximum(np.searchsorted(plan.starts[0], steps, side="right") - 1, 0)
    rates = np.degrees(plan.rates[0, maneuver])
    rate_figure = _draw_time_series(
        "Body rates", times, dict(zip("xyz", rates.T, strict=True)), "hv"
    )
    sigma_figure = _draw_time_series(
        "Attitude accuracy, 1-sigma of the worst body axis", times, {"attitude": sigma}, "linear"
    )
    return {
        "rates": rate_figure.update_yaxes(title="deg/s"),
        "attitude": sigma_figure.update_yaxes(title="deg", **build_log_axis_layout(sigma)),
    }


def _draw_time_series(title: str, times: Floats, lines: dict[str, Floats], shape: str) -> go.Figure:
    figure = go.Figure()
    for k, (name, values) in enumerate(lines.items()):
        line = {**build_line_style(k), "shape": shape}
        figure.add_scatter(x=times, y=values, name=name, mode="lines", line=line)
    figure.update_traces(hovertemplate="%{x:.6g} s: %{y:.4g}")
    figure.update_xaxes(title="time [s]", tickformat="d")
    # Omitting the template saves 7 kB per figure.
    return figure.update_layout(
        build_small_layout(title), showlegend=len(lines) > 1, template="none"
    )
