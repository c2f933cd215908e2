"""Common style of all figures, on screen and in print."""

from __future__ import annotations

from html import escape
from typing import Any

import numpy as np
import plotly.graph_objects as go
from numpy.typing import ArrayLike

#: Colors that are distinguishable with any color vision deficiency, darkest first: Okabe & Ito
#: (2008) without yellow, which is too faint on white.
COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#444444")

#: Default height of a figure on a page [px].
PAGE_HEIGHT = 560

#: Marker symbols, which distinguish traces in addition to color.
SYMBOLS = ("circle", "diamond", "square", "cross", "triangle-up", "x", "star")

#: Hints for interactive use in subtitles.
HOVER_HINT = "; hover over a point for details"
CLICK_HINT = "; click on the legend to hide a line"

GRAY = "#767676"
GRID_COLOR = "#e3e6ea"

#: Colors that have the same meaning in all figures.
PREDICTION_COLOR, MONTE_CARLO_COLOR, REQUIREMENT_COLOR = COLORS[0], COLORS[1], COLORS[3]
LOWER_BOUND_COLOR = GRAY

#: Legend below the plot, in as many rows as the width of the figure requires, so that it covers
#: neither points nor labels on screens of any width.
LEGEND = {
    "orientation": "h",
    "x": 0.5,
    "xref": "container",
    "xanchor": "center",
    "y": 0.01,
    "yref": "container",
    "yanchor": "bottom",
    "bgcolor": "rgba(0,0,0,0)",
}

# Ratio of the largest to the smallest value from which only powers of ten are labeled.
_MIN_DECADES_RATIO = 1e3
# Ratio below which labels at 1, 2 and 5 may be too few.
_MIN_DIGITS_RATIO = 5.0

#: Width and height of a figure in print [px of 1/96 inch]; the width is the column width of 88 mm
#: of the IEEE and the AIAA.
PRINT_WIDTH, PRINT_HEIGHT = 333, 240
_SCREEN_HEIGHT = 560  # Usual height on screen [px]. Higher figures have more rows.
_MAX_NARROW_SHARE = 0.5  # Share of the figure's width below which an axis has few labels.
# Font of 8 points.
_PRINT_FONT = {"family": "Times New Roman, Nimbus Roman, Liberation Serif, serif", "size": 10.7}
_PRINT_SCALE = 0.6  # Size of markers and lines in print relative to the screen.


def escape_markup(text: object, *, is_3d: bool = False) -> str:
    """Escape HTML tags and plotly templates, so that plotly displays a text literally.

    Parameters
    ----------
    text
        Text that may contain HTML tags or ``%{`` templates.
    is_3d : bool
        Whether the text is a title of a three-dimensional axis, where plotly interprets tags but
        not entities. A zero-width character then breaks the tags.
    """
    if is_3d:
        return str(text).replace("<", "<\u200b")
    return escape(str(text), quote=False).replace("{", "&#123;")


def select_symbol(index: int) -> str:
    """Return the marker symbol of a trace, given its index in the figure.

    With the color of the same index, 49 combinations are distinct.
    """
    return SYMBOLS[(index + index // len(COLORS)) % len(SYMBOLS)]


def apply_style(figure: go.Figure, title: str, subtitle: str) -> go.Figure:
    """Set the title, subtitle and common style of a figure in place, and return the figure."""
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
        legend=LEGEND,
        margin={"l": 70, "r": 20, "t": 105, "b": 80},
    )
    lines = {"gridcolor": GRID_COLOR, "linecolor": GRAY, "showline": True, "zeroline": False}
    figure.update_xaxes(**lines, ticks="outside")
    # automargin moves the axis title away from long labels such as 1.89×10⁻⁶.
    figure.update_yaxes(**lines, ticks="outside", automargin=True, title_standoff=10)
    return figure


def build_log_axis_layout(values: ArrayLike) -> dict[str, Any]:
    """Return the plotly layout of a logarithmic axis that suits the range of positive values.

    Labels are at powers of ten for a wide range and at 1, 2 and 5 for a narrower one; for a very
    narrow range, plotly chooses.
    """
    low, high = np.min(values), np.max(values)
    steps = (
        {}
        if high < _MIN_DIGITS_RATIO * low
        else {"dtick": "D2" if high < _MIN_DECADES_RATIO * low else 1}
    )
    return {"type": "log", "tickformat": find_number_format(low, high), **steps}


def find_number_format(low: float, high: float) -> str:
    """Return the plotly format for numbers in a range, in decimal or exponential notation."""
    return "~g" if low >= 1e-4 and high < 1e5 else "~e"


def format_for_print(figure: go.Figure) -> go.Figure:
    """Return a copy of a figure that is formatted for print.

    The copy has no title, 8-point text, thin lines and narrow margins.

    Colors and symbols are unchanged, so that traces differ in grayscale by symbol and dash.
    """
    printed = go.Figure(figure)
    has_shared_title = any((note.yshift or 0.0) < 0.0 for note in printed.layout.annotations)
    legend_traces = [
        trace for trace in printed.data if trace.showlegend is not False and _has_points(trace)
    ]
    height = PRINT_HEIGHT * max(1.0, (printed.layout.height or _SCREEN_HEIGHT) / _SCREEN_HEIGHT)
    printed.update_layout(
        title=None,
        template="plotly_white",
        width=PRINT_WIDTH,
        height=round(height),
        margin={"l": 8, "r": 8, "t": 8, "b": 22 if has_shared_title else 8, "pad": 0},
        font={**_PRINT_FONT, "color": "black"},
        showlegend=printed.layout.showlegend is not False and len(legend_traces) > 1,
        legend={
            "font": _PRINT_FONT,
            "title": {"text": ""},
            "orientation": "h",
            "x": 1.0,
            "xref": "paper",
            "xanchor": "right",
            "y": 1.0,
            "yref": "paper",
            "yanchor": "bottom",
            "bgcolor": "rgba(0,0,0,0)",
            "borderwidth": 0,
        },
    )
    axes = {
        "tickfont": _PRINT_FONT,
        "title": {"font": _PRINT_FONT, "standoff": 4},
        "ticklen": 3,
        "ticklabeloverflow": "allow",  # automargin makes room for a label at the end of the axis.
        "automargin": True,
    }
    printed.update_xaxes(axes).update_yaxes(axes)
    printed.for_each_xaxis(lambda axis: axis.update(nticks=4), selector=_is_narrow)
    printed.update_annotations(font={**_PRINT_FONT, "color": "black"})
    printed.update_traces(textfont_size=_PRINT_FONT["size"], selector={"type": "scatter"})
    for trace in printed.data:
        for part in ("marker", "line"):
            look = getattr(trace, part, None)
            key = "size" if part == "marker" else "width"
            if look is not None and isinstance(getattr(look, key, None), int | float):
                look[key] *= _PRINT_SCALE
    return printed


def _is_narrow(axis: Any) -> bool:
    low, high = axis.domain or (0.0, 1.0)
    return bool(high - low < _MAX_NARROW_SHARE)


def _has_points(trace: Any) -> bool:
    x = getattr(trace, "x", None)
    return x is None or len(x) > 0
