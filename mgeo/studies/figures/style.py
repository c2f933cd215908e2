"""Common style of the figures of a comparison: one color per algorithm, and one layout."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import plotly.graph_objects as go
from plotly.colors import hex_to_rgb
from pymoo.core.problem import Problem

from mgeo._typing import FloatArray
from mgeo.figures import style
from mgeo.figures.front import build_axis_layout
from mgeo.figures.style import COLORS, PAGE_HEIGHT, select_symbol

# Dashes and symbols distinguish algorithms of equal color.
_DASHES = ("solid", "6px,3px", "2px,2px")


@dataclass(frozen=True)
class TraceStyle:
    """Color, dash pattern and marker symbol of one algorithm in all figures."""

    color: str
    dash: str
    symbol: str

    def format_color(self, opacity: float) -> str:
        """Return the color as CSS text, with an opacity between 0 and 1."""
        return "rgba({},{},{},{})".format(*hex_to_rgb(self.color), opacity)

    def build_line(self, width: float) -> dict[str, Any]:
        """Return the plotly line properties of a curve of the given width [px]."""
        return {"color": self.color, "dash": self.dash, "width": width}


def assign_trace_styles(algorithms: tuple[str, ...]) -> dict[str, TraceStyle]:
    """Assign a color, dash pattern and symbol to each algorithm.

    The style depends on the position of the algorithm. Up to 21 styles are distinct.
    """
    n = len(COLORS)
    return {
        name: TraceStyle(COLORS[i % n], _DASHES[i // n % len(_DASHES)], select_symbol(i))
        for i, name in enumerate(algorithms)
    }


def validate_n_objectives(problem: Problem, *allowed: int) -> None:
    """Raise a ValueError unless the number of objectives is one of `allowed`."""
    if problem.n_obj not in allowed:
        expected = " or ".join(map(str, allowed))
        raise ValueError(f"{problem.n_obj} objectives: expected {expected} to draw fronts")


def set_axes(figure: go.Figure, names: tuple[str, ...], points: FloatArray) -> None:
    """Set the titles and scales of both axes, linear or logarithmic.

    The scales suit the coordinates of `points`, an array of shape (n, 2).
    """
    figure.update_xaxes(build_axis_layout(names[0], points[:, 0]))
    figure.update_yaxes(build_axis_layout(names[1], points[:, 1]))


def compute_height(n_rows: int) -> int:
    """Return the height of a figure with `n_rows` lines of text [px]."""
    return max(480, 220 + 26 * n_rows)


def apply_comparison_style(figure: go.Figure, title: str, subtitle: str) -> go.Figure:
    """Apply the common style, a title and a subtitle to a figure in place."""
    visible = [t for t in figure.data if t.visible is not False and t.showlegend is not False]
    return style.apply_style(figure, title, subtitle).update_layout(
        height=max(PAGE_HEIGHT, compute_height(len(visible))),
        legend_tracegroupgap=0,  # Each curve forms a group with its band, so gaps are not needed.
    )
