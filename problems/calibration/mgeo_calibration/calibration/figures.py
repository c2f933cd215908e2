"""Figures of a calibration."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd
import plotly.graph_objects as go
from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.view.figures.style import line

from mgeo.figures.style import COLORS, GRAY, finished, log_axis, symbol
from mgeo_calibration.estimation.residuals import History

#: Points of a line that are drawn, about: more cannot be distinguished.
POINTS = 1500


def calibration_figures(
    table: pd.DataFrame, believed: Floats, sensors: Sequence[str], history: History | None
) -> dict[str, go.Figure]:
    """Figures ``constants`` and, of one with history, ``innovations`` and ``attitude``.

    Parameters
    ----------
    table : DataFrame
        `Calibration.table`.
    believed : array, shape (n,)
        What its estimates were before.
    sensors : sequence of str
        Names, in the order of the history's innovations.
    """
    figures = {"constants": _constants(table.assign(change=table["estimate"] - believed))}
    if history is not None:
        figures["innovations"] = _innovations(sensors, history)
        figures["attitude"] = _attitude(history)
    return figures


def _constants(table: pd.DataFrame) -> go.Figure:
    """Estimates with 3-sigma bars, over what was believed before."""
    figure = go.Figure()
    for number, block in enumerate(table["block"].unique()):
        rows = table[table["block"] == block]
        label = str(block).replace("_", " ")
        prior = rows["prior_sigma"]
        figure.add_scatter(
            x=[f"{label} {axis}" for axis in rows["axis"]],
            y=rows["change"] / prior,
            error_y={"array": 3.0 * rows["sigma"] / prior, "thickness": 1.5, "width": 5},
            mode="markers",
            name=label,
            marker={
                "symbol": symbol(number),
                "size": 8,
                "color": COLORS[number % len(COLORS)],
            },
            customdata=rows[["estimate", "sigma", "unit"]],
            hovertemplate="%{customdata[0]:.4g} ± %{customdata[1]:.2g} %{customdata[2]}",
        )
    finished(
        figure,
        "Errors of gyro and sensors",
        "estimates with bars of 3-sigma, less what was believed before and in units of its 1-sigma",
    )
    figure.add_hline(y=0.0, line={"color": GRAY, "width": 1})
    figure.update_layout(height=480, showlegend=False)
    figure.update_xaxes(tickangle=-60)
    return figure.update_yaxes(title_text="change / initial 1-sigma [-]")


def _innovations(names: Sequence[str], history: History) -> go.Figure:
    """Mean NIS of consecutive readings, which should scatter about 1."""
    figure = go.Figure()
    for number, (name, each) in enumerate(zip(names, history.innovations, strict=True)):
        if not len(each.samples):
            continue
        pieces = np.array_split(np.arange(len(each.samples)), min(60, len(each.samples)))
        figure.add_scatter(
            x=[float(history.times[each.samples[piece]].mean()) for piece in pieces],
            y=[float((each.whitened[piece] ** 2).mean()) for piece in pieces],
            name=name,
            mode="lines+markers",
            line=line(number),
            marker={"symbol": symbol(number), "size": 7},
            hovertemplate=f"{name} %{{y:.3f}} at %{{x:.0f}} s<extra></extra>",
        )
    finished(
        figure,
        "Normalized innovations squared",
        "mean per component over pieces of the readings; 1 is what the scenario's noise explains",
    )
    figure.add_hline(y=1.0, line={"color": GRAY, "width": 1})
    figure.update_layout(height=420)
    figure.update_xaxes(title_text="time [s]")
    return figure.update_yaxes(title_text="NIS per component [-]")


def _attitude(history: History) -> go.Figure:
    """1-sigma of the worst axis against time, of filter and smoother."""
    shown: Ints = np.unique(np.linspace(0, len(history.times) - 1, POINTS).astype(np.int64))
    figure = go.Figure()
    drawn: list[Floats] = []
    for number, (name, sigma) in enumerate(
        (("filter", history.filtered_sigma), ("smoother", history.smoothed_sigma))
    ):
        worst = np.degrees(sigma[shown].max(axis=1))
        drawn.append(worst)
        figure.add_scatter(
            x=history.times[shown],
            y=worst,
            name=name,
            mode="lines",
            line=line(number),
            hovertemplate=f"{name} %{{y:.4g}} deg at %{{x:.0f}} s<extra></extra>",
        )
    finished(figure, "Attitude", "1-sigma about the worst body axis")
    figure.update_layout(height=420)
    figure.update_xaxes(title_text="time [s]")
    return figure.update_yaxes(log_axis(np.concatenate(drawn)), title_text="1-sigma [deg]")
