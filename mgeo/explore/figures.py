"""Figures of the explorer: parallel coordinates, and a scatter plot of the front."""

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
    """Plot table columns in parallel coordinates, colored by the first column.

    Columns for which `is_logarithmic` is true are drawn as decimal logarithms.

    Parameters
    ----------
    table
        Metrics of the solutions, one row each.
    names
        Columns to draw.
    """
    dimensions = []
    for name in names:
        values = table[name].to_numpy(float)
        is_log = is_logarithmic(table[name])
        values = np.log10(values) if is_log else values
        # Ticks at both ends replace the labels of the range, which would cover a second title line.
        ticks = np.linspace(values.min(), values.max(), 5)
        texts = [_format_tick(10.0**tick if is_log else tick) for tick in ticks]
        dimensions.append(
            {
                "label": _wrap_label(name),
                "name": name,
                "values": values,
                "tickvals": ticks,
                "ticktext": texts,
            }
        )
    line = {"color": dimensions[0]["values"] if dimensions else COLORS[0], "colorscale": "Viridis"}
    figure = go.Figure(go.Parcoords(dimensions=dimensions, line=line, labelfont={"size": 12}))
    return figure.update_layout(height=380, margin={"l": 70, "r": 70, "t": 85, "b": 25})


def _format_tick(value: float) -> str:
    return f"{value:.0f}" if 1e3 <= abs(value) < 1e6 else f"{value:.3g}"


def _wrap_label(name: str) -> str:
    """Escape the markup of a label, and wrap the label with ``<br>``."""
    return "<br>".join(escape_markup(line) for line in wrap(name, _MAX_LABEL_LENGTH))


def is_logarithmic(values: pd.Series) -> bool:
    """Return True if a column should be displayed on a logarithmic axis.

    All values must be finite. See `mgeo.figures.front.needs_log_axis`.
    """
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
    """Plot two metrics of the solutions, and mark the selected solution and the modified design.

    A ring marks the selected solution, and a star marks the modified design of the sliders.
    ``customdata`` of each point is the position of its solution in the table.

    Parameters
    ----------
    table
        Metrics of the solutions, one row each. The name of the index is the word for a solution.
    x, y
        Columns on the axes.
    visible_rows
        Positions of the solutions that pass the filter. Other solutions are drawn in gray.
    selected_row
        Position of the selected solution.
    design_metrics
        Metrics of the design that the sliders define, keyed by column.
    """
    hidden_rows = np.setdiff1d(np.arange(len(table)), visible_rows)
    hover = f"{table.index.name} %{{text}}<br>%{{x:.5g}}, %{{y:.5g}}<extra></extra>"
    figure = go.Figure()
    for positions, color in (
        (hidden_rows, _HIDDEN_COLOR),
        (np.asarray(visible_rows, dtype=int), COLORS[0]),
    ):
        solutions = table.iloc[positions]
        figure.add_scatter(
            x=solutions[x],
            y=solutions[y],
            mode="markers",
            customdata=positions.tolist(),  # Dash cannot decode arrays in click events.
            text=solutions.index,
            hovertemplate=hover,
            marker={"color": color, "size": 8},
        )
    ring = {"symbol": "circle-open", "size": 17, "color": COLORS[1], "line": {"width": 3}}
    star = {"symbol": "star", "size": 13, "color": COLORS[1]}
    marks = [
        (extract_row(table, selected_row), ring, f"selected {table.index.name}"),
        (design_metrics, star, "design"),
    ]
    for metrics, marker, name in marks:
        point = {"x": [metrics[x]], "y": [metrics[y]]}
        figure.add_scatter(**point, mode="markers", marker=marker, name=name, hoverinfo="skip")
    figure.update_xaxes(build_axis_layout(x, table[x].to_numpy(float)), linecolor=GRAY)
    figure.update_yaxes(
        build_axis_layout(y, table[y].to_numpy(float)), linecolor=GRAY, automargin=True
    )
    return figure.update_layout(
        template="plotly_white",
        showlegend=False,
        height=420,
        margin={"l": 70, "r": 10, "t": 10, "b": 50},
        uirevision=f"{x} {y}",  # The zoom is preserved when a mark moves.
    )


def select_rows(table: pd.DataFrame, dimensions: Sequence[Mapping[str, Any]]) -> list[int]:
    """Return the positions of the table rows within the selected ranges of all axes.

    Parameters
    ----------
    table
        Metrics of the solutions, one row each.
    dimensions
        Dimensions of the parallel-coordinates trace, as the browser returns them. An axis without
        ``constraintrange`` has no selected range, and excludes no solution.

    Returns
    -------
    list of int
        Ascending positions in the table.
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
