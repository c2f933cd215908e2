"""What the figures of a comparison share: one look per algorithm, one layout."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import plotly.graph_objects as go
from plotly.colors import hex_to_rgb
from pymoo.core.problem import Problem

from mgeo._typing import FloatArray
from mgeo.figures import style
from mgeo.figures.front import axis
from mgeo.figures.style import COLORS, PAGE_HEIGHT, symbol

# Where there are more algorithms than colors, dashes and symbols go on.
_DASHES = ("solid", "6px,3px", "2px,2px")


@dataclass(frozen=True)
class Look:
    """Color, dash and symbol of an algorithm in every figure."""

    color: str
    dash: str
    symbol: str

    def faint(self, opacity: float) -> str:
        """The color, transparent."""
        return "rgba({},{},{},{})".format(*hex_to_rgb(self.color), opacity)

    def line(self, width: float) -> dict[str, Any]:
        """The line of a curve."""
        return {"color": self.color, "dash": self.dash, "width": width}


def looks(algorithms: tuple[str, ...]) -> dict[str, Look]:
    """A look for each, by position: different ones for up to 21 algorithms."""
    n = len(COLORS)
    return {
        name: Look(COLORS[i % n], _DASHES[i // n % len(_DASHES)], symbol(i))
        for i, name in enumerate(algorithms)
    }


def require_objectives(problem: Problem, *numbers: int) -> None:
    """Refuse a problem whose objectives are not so many as can be drawn."""
    if problem.n_obj not in numbers:
        expected = " or ".join(map(str, numbers))
        raise ValueError(f"{problem.n_obj} objectives: expected {expected} to draw fronts")


def set_axes(figure: go.Figure, names: tuple[str, ...], points: FloatArray) -> None:
    """Axes of two objectives, for all points that are drawn."""
    figure.update_xaxes(axis(names[0], points[:, 0]))
    figure.update_yaxes(axis(names[1], points[:, 1]))


def row_height(rows: int) -> int:
    """Height [px] of a figure with so many rows of text."""
    return max(480, 220 + 26 * rows)


def finished(figure: go.Figure, title: str, subtitle: str) -> go.Figure:
    """`figure` with its title, room for its legend, and what all figures have in common."""
    shown = [t for t in figure.data if t.visible is not False and t.showlegend is not False]
    return style.finished(figure, title, subtitle).update_layout(
        height=max(PAGE_HEIGHT, row_height(len(shown))),
        legend_tracegroupgap=0,  # a curve and its band are a group: no room between groups
    )
