"""Colors and layout that all figures share."""

from __future__ import annotations

from typing import Any

import plotly.graph_objects as go

#: Colors that people with any color vision can tell apart: Okabe & Ito (2008), without the yellow,
#: which is too faint on white, and darkest first.
COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")

#: Marker shapes, so that no figure depends on color alone.
SYMBOLS = ("circle", "diamond", "square", "cross", "triangle-up", "x")

#: Gaps are short, so that a steep line is not taken for a gap in the data.
DASHES = ("solid", "9px,3px", "3px,3px", "12px,3px,3px,3px", "18px,3px", "6px,3px,3px,3px")

GRAY = "#767676"
GRID = "#e3e6ea"
SHADE = "#eef0f2"


def finished(figure: go.Figure, title: str, subtitle: str) -> go.Figure:
    """`figure` with the title, and what all figures have in common."""
    figure.update_layout(
        template="plotly_white",
        title={
            "text": f"{title}<br><span style='font-size: 13px'>{subtitle}</span>",
            "x": 0.02,
            "xanchor": "left",
            "y": 1.0,
            "yanchor": "top",
            "pad": {"t": 20},
        },
        font={"size": 14, "color": "#222222"},
        hoverlabel={"align": "left", "bgcolor": "white", "font": {"color": "#222222"}},
        legend={"bgcolor": "rgba(255,255,255,0.8)", "bordercolor": GRID, "borderwidth": 1},
        margin={"l": 90, "r": 40, "t": 105, "b": 70},
    )
    axis = {"gridcolor": GRID, "linecolor": GRAY, "showline": True, "zeroline": False}
    figure.update_xaxes(**axis, ticks="outside")
    figure.update_yaxes(**axis, ticks="outside")
    return figure


def title(text: str) -> dict[str, Any]:
    """The title of one of many small figures."""
    return {
        "text": text,
        "x": 0.02,
        "xanchor": "left",
        "y": 1.0,
        "yref": "container",
        "yanchor": "top",
        "pad": {"t": 9},
        "font": {"size": 15},
    }
