"""Figures of the explorer: parallel coordinates, and a scatter plot of two columns."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from textwrap import wrap
from typing import Any

import numpy as np
import pandas as pd
import plotly.graph_objects as go

from mgeo.explore.explorer import extract_row
from mgeo.figures.front import build_axis_layout, needs_log_axis
from mgeo.figures.style import COLORS, GRAY, escape_markup

_HIDDEN_COLOR = "#d4d8de"
_MAX_LABEL_LENGTH = 18  # maximum line length of an axis label


def draw_parallel_coordinates(table: pd.DataFrame, names: Sequence[str]) -> go.Figure:
    """Return parallel coordinates of table columns, colored by the first column.

    Columns selected by `mgeo.figures.front.logarithmic` are drawn as decimal logarithms.

    Parameters
    ----------
    table
        Numbers of the solutions.
    names
        Columns to draw.
    """
    dimensions = []
    for name in names:
        values = table[name].to_numpy(float)
        dimension = {"label": _wrap_label(name), "name": name, "values": values}
        if is_logarithmic(table[name]):
            shown = np.log10(values)
            ticks = np.linspace(shown.min(), shown.max(), 5)
            texts = [f"{value:.3g}" for value in 10.0**ticks]
            dimension |= {"values": shown, "tickvals": ticks, "ticktext": texts}
        dimensions.append(dimension)
    line = {"color": dimensions[0]["values"] if dimensions else COLORS[0], "colorscale": "Viridis"}
    figure = go.Figure(go.Parcoords(dimensions=dimensions, line=line, labelfont={"size": 12}))
    return figure.update_layout(height=380, margin={"l": 70, "r": 70, "t": 85, "b": 25})


def _wrap_label(name: str) -> str:
    return "<br>".join(escape_markup(line) for line in wrap(name, _MAX_LABEL_LENGTH))


def is_logarithmic(values: pd.Series) -> bool:
    """Return whether a column is drawn on a logarithmic axis."""
    numbers = values.to_numpy(float)
    return bool(np.isfinite(numbers).all()) and needs_log_axis(numbers)


def draw_front(
    table: pd.DataFrame,
    x: str,
    y: str,
    visible_rows: Sequence[int],
    selected_row: int,
    design_metrics: Mapping[str, float],
) -> go.Figure:
    """Return a scatter plot of two columns; ``customdata`` of each point is its table position.

    Parameters
    ----------
    table
        Numbers of the solutions.
    x, y
        Columns of the axes.
    visible_rows
        Positions of the solutions that pass the filter; other solutions are drawn faint.
    selected_row
        Position of the selected solution.
    design_metrics
        Numbers of the design set by the sliders.
    """
    rest = np.setdiff1d(np.arange(len(table)), visible_rows)
    hover = "solution %{text}<br>%{x:.5g}, %{y:.5g}<extra></extra>"
    figure = go.Figure()
    for positions, color in (
        (rest, _HIDDEN_COLOR),
        (np.asarray(visible_rows, dtype=int), COLORS[0]),
    ):
        part = table.iloc[positions]
        figure.add_scatter(
            x=part[x],
            y=part[y],
            mode="markers",
            customdata=positions.tolist(),  # Dash cannot read encoded arrays.
            text=part.index,
            hovertemplate=hover,
            marker={"color": color, "size": 8},
        )
    ring = {"symbol": "circle-open", "size": 17, "color": COLORS[1], "line": {"width": 3}}
    star = {"symbol": "star", "size": 13, "color": COLORS[1]}
    marks = [
        (extract_row(table, selected_row), ring, "selected solution"),
        (design_metrics, star, "design"),
    ]
    for numbers, marker, name in marks:
        place = {"x": [numbers[x]], "y": [numbers[y]]}
        figure.add_scatter(**place, mode="markers", marker=marker, name=name, hoverinfo="skip")
    figure.update_xaxes(build_axis_layout(x, table[x].to_numpy(float)), linecolor=GRAY)
    figure.update_yaxes(
        build_axis_layout(y, table[y].to_numpy(float)), linecolor=GRAY, automargin=True
    )
    return figure.update_layout(
        template="plotly_white",
        showlegend=False,
        height=420,
        margin={"l": 70, "r": 10, "t": 10, "b": 50},
        uirevision=f"{x} {y}",  # preserves the zoom when a marker moves
    )


def select_rows(table: pd.DataFrame, dimensions: Sequence[Mapping[str, Any]]) -> list[int]:
    """Return the positions of the rows within the selected ranges of all dimensions.

    Parameters
    ----------
    table
        Numbers of the solutions.
    dimensions
        Dimensions of a parallel-coordinates trace, as returned by the browser.
    """
    is_within = np.ones(len(table), dtype=bool)
    for dimension in dimensions:
        ranges = dimension.get("constraintrange")
        if not ranges:
            continue
        values = table[dimension["name"]].to_numpy(float)
        values = np.log10(values) if is_logarithmic(table[dimension["name"]]) else values
        within = [(low <= values) & (values <= high) for low, high in np.reshape(ranges, (-1, 2))]
        is_within &= np.any(within, axis=0)
    return np.flatnonzero(is_within).tolist()
