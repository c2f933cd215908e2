"""What the figures of a comparison share: one look per algorithm, one layout."""

from __future__ import annotations

from dataclasses import dataclass

import plotly.graph_objects as go

from mgeo.figures.page import HEIGHT

# Okabe & Ito (2008), tell apart by people with any color vision; without the yellow, which is too
# faint on white. Where there are more algorithms than colors, dashes and symbols go on.
_COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#444444")
_DASHES = ("solid", "6px,3px", "2px,2px")
_SYMBOLS = ("circle", "diamond", "square", "cross", "triangle-up", "x", "star")
_GRID = "#e3e6ea"


@dataclass(frozen=True)
class Look:
    """Color, dash and symbol of an algorithm in every figure."""

    color: str
    dash: str
    symbol: str

    def faint(self, opacity: float) -> str:
        """The color, transparent."""
        red, green, blue = (int(self.color[i : i + 2], 16) for i in (1, 3, 5))
        return f"rgba({red},{green},{blue},{opacity})"


def looks(algorithms: tuple[str, ...]) -> dict[str, Look]:
    """A look for each, by position: different ones for up to 21 algorithms."""
    n = len(_COLORS)
    return {
        name: Look(
            _COLORS[i % n], _DASHES[i // n % len(_DASHES)], _SYMBOLS[(i + i // n) % len(_SYMBOLS)]
        )
        for i, name in enumerate(algorithms)
    }


def row_height(rows: int) -> int:
    """Height [px] of a figure with so many rows of text."""
    return max(480, 220 + 26 * rows)


def finished(figure: go.Figure, title: str, subtitle: str) -> go.Figure:
    """`figure` with its title, room for its legend, and what all figures have in common."""
    shown = [t for t in figure.data if t.visible is not False and t.showlegend is not False]
    figure.update_layout(
        height=max(HEIGHT, row_height(len(shown))),
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
        legend={
            "bgcolor": "rgba(255,255,255,0.8)",
            "bordercolor": _GRID,
            "borderwidth": 1,
            "tracegroupgap": 0,  # a curve and its band are a group: no room between groups
        },
        margin={"l": 90, "r": 40, "t": 105, "b": 70},
    )
    lines = {"gridcolor": _GRID, "linecolor": "#767676", "showline": True, "zeroline": False}
    figure.update_xaxes(**lines, ticks="outside")
    figure.update_yaxes(**lines, ticks="outside")
    return figure
