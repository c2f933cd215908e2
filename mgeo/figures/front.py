"""Interactive figure of a front with one to three objectives, for problems without their own."""

from __future__ import annotations

from numbers import Real
from typing import TYPE_CHECKING, Any

import numpy as np
import plotly.graph_objects as go
from numpy.typing import NDArray

from mgeo.figures.style import COLORS, GRID_COLOR, build_log_axis_layout, escape_markup

if TYPE_CHECKING:
    import pandas as pd

#: Maximum number of objectives that can be drawn.
MAX_OBJECTIVES = 3

#: Maximum number of points with hover texts, and with figures that the problem draws.
MAX_HOVER_TEXTS = 2000

_MIN_LOG_RATIO = 20.0  # Minimum ratio of the largest to the smallest value on a logarithmic axis.
_MARKER = {"size": 7, "color": COLORS[0], "line": {"width": 0.5, "color": "white"}}
_MARKER_3D = {"size": 4, "color": COLORS[0]}
_BOUNDARY = {"shape": "hv", "width": 1, "color": "#9db7d5"}


def draw_front(
    X: NDArray[np.float64],
    F: NDArray[np.float64],
    variables: tuple[str, ...],
    objectives: tuple[str, ...],
    title: str = "",
    descriptions: pd.DataFrame | None = None,
) -> go.Figure:
    """Draw the front of a problem with one to three objectives.

    Hover texts show the variables of each solution.

    One objective is drawn over the number of the solution, two objectives with the boundary of the
    dominated region, and three objectives in 3D. Axes are logarithmic if `needs_log_axis` is true.

    Parameters
    ----------
    X : array, shape (n, n_var)
        Variables of the solutions.
    F : array, shape (n, n_obj)
        Objectives of the solutions.
    variables, objectives : tuple of str
        Names of the variables and objectives, with units.
    title : str
        Title of the figure.
    descriptions : DataFrame, optional
        Description of each solution by its problem, one row each, to show instead of the variables.

    Returns
    -------
    plotly.graph_objects.Figure

    Raises
    ------
    ValueError
        If there are more than three objectives.
    """
    if len(objectives) > MAX_OBJECTIVES:
        raise ValueError(
            f"{len(objectives)} objectives: expected at most {MAX_OBJECTIVES} to draw the front"
        )
    points: dict[str, Any] = {"mode": "markers", "customdata": np.arange(len(F))}
    if len(F) <= MAX_HOVER_TEXTS:
        texts = format_hover_texts(X, F, variables, objectives, descriptions)
        points |= {"hovertext": texts, "hoverinfo": "text"}
    is_3d = len(objectives) == 3
    axes = [
        build_axis_layout(name, f, is_3d=is_3d) for name, f in zip(objectives, F.T, strict=True)
    ]
    figure = go.Figure()
    if len(axes) == 1:
        figure.add_scatter(x=np.arange(len(F)), y=F[:, 0], marker=_MARKER, **points)
        figure.update_xaxes(title="solution", dtick=1 if len(F) < 20 else None)
        figure.update_yaxes(axes[0])
    elif len(axes) == 2:
        x, y = F[np.lexsort((F[:, 1], F[:, 0]))].T
        figure.add_scatter(x=x, y=y, mode="lines", line=_BOUNDARY, hoverinfo="skip")
        figure.add_scatter(x=F[:, 0], y=F[:, 1], marker=_MARKER, **points)
        figure.update_xaxes(axes[0]).update_yaxes(axes[1])
    else:
        figure.add_scatter3d(x=F[:, 0], y=F[:, 1], z=F[:, 2], marker=_MARKER_3D, **points)
        figure.update_scenes(dict(zip(("xaxis", "yaxis", "zaxis"), axes, strict=True)))
        figure.update_scenes(camera_eye=dict.fromkeys("xyz", 1.6))  # Shows the whole front.
    return figure.update_layout(
        title=escape_markup(title),
        template="plotly_white",
        showlegend=False,
        font_size=14,
        hoverlabel_align="left",
    )


def format_hover_texts(
    X: NDArray[np.float64],
    F: NDArray[np.float64],
    variables: tuple[str, ...],
    objectives: tuple[str, ...],
    descriptions: pd.DataFrame | None = None,
) -> list[str]:
    """Return one hover text per solution with its number, objectives and variables.

    The descriptions of the solutions, if given, replace the variables.

    The parameters are those of `draw_front`.
    """
    names, rows = list(variables), X.tolist()
    if descriptions is not None:
        table = descriptions.drop(columns=list(objectives), errors="ignore")
        names, rows = list(map(str, table.columns)), list(table.itertuples(index=False))
    objectives, names = tuple(map(escape_markup, objectives)), list(map(escape_markup, names))
    texts = []
    for number, (row, f) in enumerate(zip(rows, F, strict=True)):
        lines = [f"solution {number}"]
        lines += [f"<b>{name}: {value:.6g}</b>" for name, value in zip(objectives, f, strict=True)]
        lines += [f"{name}: {_format_value(value)}" for name, value in zip(names, row, strict=True)]
        texts.append("<br>".join(lines))
    return texts


def _format_value(value: object) -> str:
    return f"{value:.5g}" if isinstance(value, Real) else escape_markup(value)


def build_axis_layout(
    name: str, values: NDArray[np.float64], *, is_3d: bool = False
) -> dict[str, object]:
    """Return the plotly layout for the axis of an objective.

    The axis is logarithmic if `needs_log_axis` is true for the values.

    Parameters
    ----------
    name : str
        Name of the objective, with its unit.
    values : array, shape (n,)
        Values to draw.
    is_3d : bool
        Whether the axis belongs to a three-dimensional figure.
    """
    layout: dict[str, object] = {
        "title": {"text": escape_markup(name, is_3d=is_3d)},
        "gridcolor": GRID_COLOR,
    }
    if needs_log_axis(values):
        return layout | build_log_axis_layout(values)
    largest = np.abs(values).max() if len(values) else 1.0
    return layout | {"exponentformat": "none" if 1e-3 <= largest < 1e5 else "power"}


def needs_log_axis(values: NDArray[np.float64]) -> bool:
    """Return True if all values are positive and a logarithmic axis spreads them more evenly.

    The values must span a factor of 20 or more, and their logarithms must be distributed more
    symmetrically than the values. Symmetry is measured by the median between the 2 % and 98 %
    quantiles, so that a single value near zero has no influence.
    """
    if not len(values) or values.min() <= 0 or values.max() < _MIN_LOG_RATIO * values.min():
        return False
    low, median, high = np.quantile(values, [0.02, 0.5, 0.98])
    skewness = abs(low + high - 2.0 * median) / (high - low)
    return bool(abs(np.log(low * high / median**2)) / np.log(high / low) < skewness)
