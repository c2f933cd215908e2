"""Common style of the figures of a comparison: a color per algorithm, and one layout."""

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

# Dashes and symbols distinguish algorithms of equal color.
_DASHES = ("solid", "6px,3px", "2px,2px")


@dataclass(frozen=True)
class Look:
    """Color, dash and symbol that identify an algorithm in all figures."""

    color: str
    dash: str
    symbol: str

    def faint(self, opacity: float) -> str:
        """Return the color as CSS text with an opacity between 0 and 1."""
        return "rgba({},{},{},{})".format(*hex_to_rgb(self.color), opacity)

    def line(self, width: float) -> dict[str, Any]:
        """Return plotly's line properties of a curve; the width is in pixels."""
        return {"color": self.color, "dash": self.dash, "width": width}


def looks(algorithms: tuple[str, ...]) -> dict[str, Look]:
    """Return the look of each algorithm by position; up to 21 looks are distinct."""
    n = len(COLORS)
    return {
        name: Look(COLORS[i % n], _DASHES[i // n % len(_DASHES)], symbol(i))
        for i, name in enumerate(algorithms)
    }


def require_objectives(problem: Problem, *numbers: int) -> None:
    """Raise ValueError if the number of objectives is not one of `numbers`."""
    if problem.n_obj not in numbers:
        expected = " or ".join(map(str, numbers))
        raise ValueError(f"{problem.n_obj} objectives: expected {expected} to draw fronts")


def set_axes(figure: go.Figure, names: tuple[str, ...], points: FloatArray) -> None:
    """Set titles and ranges of both axes for points of shape (n, 2)."""
    figure.update_xaxes(axis(names[0], points[:, 0]))
    figure.update_yaxes(axis(names[1], points[:, 1]))


def row_height(rows: int) -> int:
    """Return the height [px] of a figure with `rows` lines of text."""
    return max(480, 220 + 26 * rows)


def finished(figure: go.Figure, title: str, subtitle: str) -> go.Figure:
    """Return the figure with title, subtitle, common style and space for the legend."""
    shown = [t for t in figure.data if t.visible is not False and t.showlegend is not False]
    return style.finished(figure, title, subtitle).update_layout(
        height=max(PAGE_HEIGHT, row_height(len(shown))),
        legend_tracegroupgap=0,  # Each curve and its band form a group.
    )
