"""Plotly figures of a calibration."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd
import plotly.graph_objects as go
from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.view.figures.style import build_line_style

from mgeo.figures.style import (
    COLORS,
    GRAY,
    apply_style,
    build_log_axis_layout,
    select_symbol,
)
from mgeo_calibration.calibration.corrections import format_label
from mgeo_calibration.estimation.residuals import History

#: Approximate number of points per line; more cannot be distinguished.
N_POINTS = 1500


def draw_calibration_figures(
    table: pd.DataFrame, prior: Floats, sensors: Sequence[str], history: History | None
) -> dict[str, go.Figure]:
    """Return a dict of Plotly figures: ``parameters``, ``innovations`` and ``attitude``.

    Without an attitude history, the dict only contains the figure ``parameters``.

    Parameters
    ----------
    table : DataFrame
        Result of `Calibration.build_table`.
    prior : array, shape (n,)
        Prior estimate of the parameter in each row of the table, in its unit.
    sensors : sequence of str
        Sensor names in the order of the history's innovations.
    history : History, optional
    """
    figures = {"parameters": _plot_parameters(table.assign(change=table["estimate"] - prior))}
    if history is not None:
        figures["innovations"] = _plot_innovations(sensors, history)
        figures["attitude"] = _plot_attitude(history)
    return figures


def _plot_parameters(table: pd.DataFrame) -> go.Figure:
    """Plot the change of each calibration parameter from its prior, with 3-sigma bars, in units of
    the prior 1-sigma.
    """
    figure = go.Figure()
    for number, block in enumerate(table["block"].unique()):
        rows = table[table["block"] == block]
        label = format_label(str(block))
        prior = rows["prior_sigma"]
        figure.add_scatter(
            x=rows["change"] / prior,
            y=[f"{label} {axis}" for axis in rows["axis"]],
            error_x={"array": 3.0 * rows["sigma"] / prior, "thickness": 1.5, "width": 5},
            mode="markers",
            name=label,
            marker={
                "symbol": select_symbol(number),
                "size": 8,
                "color": COLORS[number % len(COLORS)],
            },
            customdata=rows[["estimate", "sigma", "unit"]],
            hovertemplate="%{customdata[0]:.4g} ± %{customdata[1]:.2g} %{customdata[2]}",
        )
    apply_style(
        figure,
        "Change of the calibration parameters",
        "estimates relative to their prior with 3-sigma bars; shaded: initial 1-sigma",
    )
    figure.add_vrect(-1.0, 1.0, fillcolor=GRAY, opacity=0.15, line_width=0, layer="below")
    figure.add_vline(x=0.0, line={"color": GRAY, "width": 1})
    figure.update_layout(height=190 + 22 * len(table), showlegend=False)
    figure.update_xaxes(title_text="(estimate - prior) / initial 1-sigma [-]")
    return figure.update_yaxes(autorange="reversed", tickmode="linear")


def _plot_innovations(names: Sequence[str], history: History) -> go.Figure:
    """Plot the normalized innovations squared (NIS) of each sensor over time, averaged over up to
    60 groups of consecutive readings.
    """
    figure = go.Figure()
    for number, (name, each) in enumerate(zip(names, history.innovations, strict=True)):
        if not len(each.samples):
            continue
        pieces = np.array_split(np.arange(len(each.samples)), min(60, len(each.samples)))
        times = np.array([history.times[each.samples[piece]].mean() for piece in pieces])
        values = np.array([(each.whitened_values[piece] ** 2).mean() for piece in pieces])
        steps = np.diff(times)
        gaps = np.flatnonzero(steps > 3.0 * np.median(steps)) + 1  # such as an eclipse
        figure.add_scatter(
            x=np.insert(times, gaps, np.nan),
            y=np.insert(values, gaps, np.nan),
            name=name,
            mode="lines+markers",
            line=build_line_style(number),
            marker={"symbol": select_symbol(number), "size": 7},
            hovertemplate=f"{name} %{{y:.3f}} at %{{x:.0f}} s<extra></extra>",
        )
    apply_style(
        figure,
        "Normalized innovations squared",
        "mean per component over consecutive readings; 1 if readings scatter as declared",
    )
    figure.add_hline(y=1.0, line={"color": GRAY, "width": 1})
    figure.update_layout(height=420)
    figure.update_xaxes(title_text="time after the epoch [s]", tickformat=",d")
    return figure.update_yaxes(title_text="NIS per component [-]")


def _plot_attitude(history: History) -> go.Figure:
    shown: Ints = np.unique(np.linspace(0, len(history.times) - 1, N_POINTS).astype(np.int64))
    figure = go.Figure()
    drawn: list[Floats] = []
    for number, (name, sigma) in enumerate(
        (
            ("filter, earlier readings", history.filtered_sigma),
            ("smoother, all readings", history.smoothed_sigma),
        )
    ):
        worst = np.degrees(sigma[shown].max(axis=1))
        drawn.append(worst)
        figure.add_scatter(
            x=history.times[shown],
            y=worst,
            name=name,
            mode="lines",
            line=build_line_style(number),
            hovertemplate=f"{name} %{{y:.4g}} deg at %{{x:.0f}} s<extra></extra>",
        )
    apply_style(figure, "Attitude accuracy", "1-sigma about the worst body axis")
    figure.update_layout(height=420)
    figure.update_xaxes(title_text="time after the epoch [s]", tickformat=",d")
    return figure.update_yaxes(
        build_log_axis_layout(np.concatenate(drawn)), title_text="attitude 1-sigma [deg]"
    )
