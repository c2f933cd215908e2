"""Figures for a paper: as wide as a column, in its fonts, without what a caption says better."""

from __future__ import annotations

from typing import Any

import plotly.graph_objects as go

#: Width [px of 1/96 inch] of a column of 88 mm, that of the IEEE and of the AIAA.
WIDTH, HEIGHT = 333, 240
#: 8 points.
_FONT = {"family": "Times New Roman, Nimbus Roman, Liberation Serif, serif", "size": 10.7}
_SMALLER = 0.6  # markers and lines, of what they are on a screen
_MAP = {"l": 8, "r": 8, "b": 8}  # margins where no axis is drawn


def for_paper(figure: go.Figure) -> go.Figure:
    """A copy for print: no title, black text of 8 points, thin lines, little margin.

    Colors and shapes stay; they can be distinguished in gray by shape and dash.
    """
    still = go.Figure(figure)
    layout = still.layout.to_plotly_json()
    above = layout.get("xaxis2", {}).get("side") == "top"
    margin = {"l": 52, "r": 8, "t": 44 if above else 22, "b": 38, "pad": 0}
    bare = layout.get("xaxis", {}).get("visible") is False
    if above:  # the legend stands inside, where the text along a line would; the axis says the same
        still.layout.annotations = [each for each in still.layout.annotations if not each.textangle]
    still.update_layout(
        title=None,
        template="plotly_white",
        width=WIDTH,
        height=HEIGHT,
        margin=margin | _MAP if bare else margin,
        font={**_FONT, "color": "black"},
    )
    named = [each for each in still.data if each.showlegend is not False and _drawn(each)]
    still.update_layout(
        showlegend=len(named) > 1,
        legend={
            "font": _FONT,
            "title": {"text": ""},
            "orientation": "h",
            "x": 1.0,
            "xanchor": "right",
            "y": 1.0 if not above else 0.99,
            "yref": "paper",
            "yanchor": "bottom" if not above else "top",
            "bgcolor": "rgba(255,255,255,0.9)",
            "borderwidth": 0,
        },
    )
    axes = {"tickfont": _FONT, "title": {"font": _FONT, "standoff": 4}, "ticklen": 3}
    still.update_xaxes(axes).update_yaxes(axes)
    still.update_annotations(font={**_FONT, "color": "black"})
    for trace in still.data:
        for part in ("marker", "line"):
            look = getattr(trace, part, None)
            key = "size" if part == "marker" else "width"
            if look is not None and isinstance(getattr(look, key, None), int | float):
                look[key] *= _SMALLER
    return still


def _drawn(trace: Any) -> bool:
    x = getattr(trace, "x", None)
    return x is None or len(x) > 0
