"""Correlations of the errors that a plan leaves."""

from __future__ import annotations

import pandas as pd
import plotly.graph_objects as go

from mgeo.figures.style import COLORS, finished

_CELL = 30
_MARGINS = 260


def correlation_figure(correlations: pd.DataFrame) -> go.Figure:
    """Heat map of a table of correlations, such as `observability.correlations` gives.

    From -1 (blue) over 0 (white) to 1 (orange); a pair far from zero is known better as a sum or
    difference than each of the two.
    """
    names = list(correlations.columns)
    figure = go.Figure(
        go.Heatmap(
            z=correlations.to_numpy(),
            x=names,
            y=names,
            zmin=-1.0,
            zmax=1.0,
            colorscale=[[0.0, COLORS[0]], [0.5, "#ffffff"], [1.0, COLORS[1]]],
            colorbar={"title": {"text": "correlation"}, "outlinewidth": 0},
            xgap=1,
            ygap=1,
            hovertemplate="%{y} and %{x}: %{z:.3f}<extra></extra>",
        )
    )
    finished(
        figure,
        "Correlation of the errors at t_end",
        "far from zero: the two are known better together than each by itself",
    )
    size = _MARGINS + _CELL * len(names)
    figure.update_layout(height=size, margin={"l": 150, "b": 150})
    figure.update_xaxes(tickangle=-60, showgrid=False)
    figure.update_yaxes(autorange="reversed", showgrid=False, scaleanchor="x", constrain="domain")
    figure.update_xaxes(constrain="domain")
    return figure
