"""The look that all figures share, on screen and on paper."""

from __future__ import annotations

import math
from html import escape
from typing import Any

import numpy as np
import plotly.graph_objects as go
from numpy.typing import ArrayLike

#: Colors that people with any color vision can tell apart: Okabe & Ito (2008), without the yellow,
#: which is too faint on white, and darkest first.
COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#444444")

#: Height of a figure on a page that names none [px].
PAGE_HEIGHT = 560

#: Marker shapes, so that no figure depends on color alone.
SYMBOLS = ("circle", "diamond", "square", "cross", "triangle-up", "x", "star")

#: What subtitles say to whoever sees a figure on a screen.
HOVER = "; hover over one for its plan"
CLICK = "; click the legend to hide"

GRAY = "#767676"
GRID = "#e3e6ea"

#: Ratio of largest to smallest value from which only powers of ten are labeled.
_WIDE = 1e3
#: And up to which there may be none, or but one, at 1, 2 and 5.
_CLOSE = 5.0

#: Width [px of 1/96 inch] of a column of 88 mm, that of the IEEE and of the AIAA.
WIDTH, HEIGHT = 333, 240
_ON_SCREEN = 560  # px, the usual height: what is higher has more rows
_NARROW = 0.5  # share of the width of an axis on which few labels find room
_LETTER, _ENTRY, _LINE = 5.2, 45, 17  # px of a legend: a letter, what is beside them, a row
#: 8 points.
_FONT = {"family": "Times New Roman, Nimbus Roman, Liberation Serif, serif", "size": 10.7}
_SMALLER = 0.6  # markers and lines, of what they are on a screen
_MAP = {"l": 8, "r": 8, "b": 8}  # margins where no axis is drawn


def literal(text: object, *, in_space: bool = False) -> str:
    """Somebody's text as it is: plotly takes tags for markup, and ``%{`` for a template.

    Titles of axes in space know tags, but no entities: there a character without width breaks tags.
    """
    if in_space:
        return str(text).replace("<", "<\u200b")
    return escape(str(text), quote=False).replace("{", "&#123;")


def symbol(index: int) -> str:
    """Marker of one of several lines; with the color of that number no two of 49 are alike."""
    return SYMBOLS[(index + index // len(COLORS)) % len(SYMBOLS)]


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
    lines = {"gridcolor": GRID, "linecolor": GRAY, "showline": True, "zeroline": False}
    figure.update_xaxes(**lines, ticks="outside")
    # labels such as 1.89×10⁻⁶ push the title aside instead of lying on it
    figure.update_yaxes(**lines, ticks="outside", automargin=True, title_standoff=10)
    return figure


def log_axis(values: ArrayLike) -> dict[str, Any]:
    """Layout of a logarithmic axis for these values, with labels at 1, 2 and 5 if they are near.

    If they are so near that there might be none of these between them, plotly chooses.
    """
    low, high = np.min(values), np.max(values)
    steps = {} if high < _CLOSE * low else {"dtick": "D2" if high < _WIDE * low else 1}
    return {"type": "log", "exponentformat": "power", **steps}


def for_paper(figure: go.Figure) -> go.Figure:
    """A copy for print: no title, black text of 8 points, thin lines, little margin.

    Colors and shapes stay; they can be distinguished in gray by shape and dash.
    """
    still = go.Figure(figure)
    layout = still.layout.to_plotly_json()
    above = layout.get("xaxis2", {}).get("side") == "top"
    margin = {"l": 52, "r": 8, "t": 44 if above else 22, "b": 38, "pad": 0}
    bare = layout.get("xaxis", {}).get("visible") is False
    below = [each.yshift for each in still.layout.annotations if each.yshift]
    if min(below, default=0.0) < 0.0:  # a title of several axes
        margin["b"] += 14
    if above:  # the legend stands inside, where the text along a line would; the axis says the same
        still.layout.annotations = [each for each in still.layout.annotations if not each.textangle]
    named = [each for each in still.data if each.showlegend is not False and _drawn(each)]
    legend = still.layout.showlegend is not False and len(named) > 1
    rows = _legend_rows([each.name or "" for each in named]) if legend and not above else 1
    higher = max(1.0, (still.layout.height or _ON_SCREEN) / _ON_SCREEN)
    still.update_layout(
        title=None,
        template="plotly_white",
        width=WIDTH,
        height=round(HEIGHT * higher) + _LINE * (rows - 1),
        margin=margin | _MAP if bare else margin,
        font={**_FONT, "color": "black"},
    )
    still.update_layout(
        showlegend=legend,
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
    still.for_each_xaxis(lambda each: each.update(nticks=4), selector=_narrow)
    still.update_annotations(font={**_FONT, "color": "black"})
    for trace in still.data:
        for part in ("marker", "line"):
            look = getattr(trace, part, None)
            key = "size" if part == "marker" else "width"
            if look is not None and isinstance(getattr(look, key, None), int | float):
                look[key] *= _SMALLER
    return still


def _narrow(axis: Any) -> bool:
    low, high = axis.domain or (0.0, 1.0)
    return bool(high - low < _NARROW)


def _legend_rows(names: list[str]) -> int:
    """Rows of a legend whose entries are all as wide as the widest, about."""
    widest = _ENTRY + _LETTER * max(map(len, names))
    return math.ceil(len(names) / max(1, WIDTH // widest))


def _drawn(trace: Any) -> bool:
    x = getattr(trace, "x", None)
    return x is None or len(x) > 0
