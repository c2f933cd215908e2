"""Figures of the fronts of all runs, and of the share of runs that attain each point."""

from __future__ import annotations

from math import ceil
from typing import Any

import moocore
import numpy as np
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from mgeo._typing import FloatArray
from mgeo.figures.front import build_axis_layout
from mgeo.figures.style import CLICK_HINT, escape_markup
from mgeo.studies.comparison import Comparison
from mgeo.studies.figures.style import (
    apply_comparison_style,
    assign_trace_styles,
    set_axes,
    validate_n_objectives,
)

_N_COLUMNS = 3
_ROW_HEIGHT = 300
_COORDINATES = ("x", "y", "z")

_ATTAINMENT_SURFACES = (
    (50, "half of the runs", 2.0),
    (0, "the best run", 1.0),
    (100, "every run", 1.0),
)
_MAX_CELLS = 300  # Maximum number of heat-map cells along each objective.


def draw_median_fronts(comparison: Comparison) -> go.Figure:
    """Draw the front of the median run of each algorithm.

    Raises
    ------
    ValueError
        Unless there are two or three objectives.
    """
    n_obj = comparison.problem.n_obj
    validate_n_objectives(comparison.problem, 2, 3)
    figure, drawn = go.Figure(), [np.empty((0, n_obj))]
    for name, trace_style in assign_trace_styles(comparison.algorithms).items():
        seed = comparison.find_median_seed(name)
        if seed is None:
            continue
        F = comparison.finished_runs[name, seed].front_F
        F = F[np.lexsort(F.T[::-1])]
        drawn.append(F)
        style: dict[str, Any] = {
            "mode": "markers",
            "marker": {"size": 3, "color": trace_style.color},
        }
        if n_obj == 2:
            line = {
                "shape": "hv",
                "width": 1,
                "color": trace_style.format_color(0.5),
                "dash": trace_style.dash,
            }
            marker = {
                "size": 6,
                "color": trace_style.color,
                "symbol": trace_style.symbol,
                "opacity": 0.8,
            }
            style = {"mode": "lines+markers", "marker": marker, "line": line}
        figure.add_trace(
            _build_points_trace(F, name, f"seed {seed}", comparison.objectives, **style)
        )
        figure.data[-1].name = escape_markup(f"{name}, seed {seed}")
    points = np.concatenate(drawn)
    if n_obj == 2:
        set_axes(figure, comparison.objectives, points)
    else:
        axes = zip(_COORDINATES, comparison.objectives, points.T, strict=True)
        scene = {
            f"{key}axis": build_axis_layout(name, values, is_3d=True) for key, name, values in axes
        }
        figure.update_scenes(scene)
    return apply_comparison_style(
        figure,
        "Fronts of typical runs",
        f"run of each algorithm with the median {comparison.select_indicator().title}; "
        f"nondominated points among all its {comparison.n_eval:,} evaluations",
    )


def draw_front_panels(comparison: Comparison) -> go.Figure:
    """Draw the fronts of all runs in one panel per algorithm, with the median run in color.

    Raises
    ------
    ValueError
        Unless there are two objectives.
    """
    validate_n_objectives(comparison.problem, 2)
    names = [name for name in comparison.algorithms if any(map(len, comparison.list_fronts(name)))]
    rows = ceil(len(names) / _N_COLUMNS)
    figure = make_subplots(
        rows=rows,
        cols=_N_COLUMNS,
        shared_xaxes="all",
        shared_yaxes="all",
        subplot_titles=list(map(escape_markup, names)),
        vertical_spacing=0.25 / rows,
        horizontal_spacing=0.07,
        x_title=escape_markup(comparison.objectives[0]),
        y_title=escape_markup(comparison.objectives[1]),
    )
    styles = assign_trace_styles(comparison.algorithms)
    drawn = [np.concatenate(comparison.list_fronts(name)) for name in names]
    for i, (name, points) in enumerate(zip(names, drawn, strict=True)):
        seed = comparison.find_median_seed(name)
        layers = [(points, f"one of {len(comparison.list_fronts(name))} runs", 3, "#b5b5b5")]
        if seed is not None:
            median = comparison.finished_runs[name, seed].front_F
            layers.append((median, f"seed {seed}", 5, styles[name].color))
        for F, run, size, color in layers:
            marker = {"size": size, "color": color}
            trace = _build_points_trace(
                F, name, run, comparison.objectives, mode="markers", marker=marker
            )
            figure.add_trace(trace, row=i // _N_COLUMNS + 1, col=i % _N_COLUMNS + 1)
    set_axes(figure, ("", ""), np.concatenate(drawn))
    figure.update_xaxes(showticklabels=True, nticks=3, tickangle=0)
    figure.update_yaxes(showticklabels=True)
    apply_comparison_style(
        figure,
        "Fronts of all runs",
        f"gray: all runs; in color: the run with the median {comparison.select_indicator().title}; "
        "equal axes, zoomed together",
    )
    return figure.update_layout(height=180 + _ROW_HEIGHT * rows, showlegend=False)


def draw_attainment_surfaces(comparison: Comparison) -> go.Figure:
    """Draw the best, median and worst empirical attainment surface of each algorithm.

    Raises
    ------
    ValueError
        Unless there are two objectives.
    """
    validate_n_objectives(comparison.problem, 2)
    figure, drawn = go.Figure(), [np.empty((0, 2))]
    for name, trace_style in assign_trace_styles(comparison.algorithms).items():
        # A run with an empty front counts but attains no point, like a point at infinity.
        fronts = [f if len(f) else np.full((1, 2), np.inf) for f in comparison.list_fronts(name)]
        points = np.concatenate([np.empty((0, 2)), *fronts])
        if not np.isfinite(points).any():
            continue
        sets = np.repeat(np.arange(1.0, len(fronts) + 1), list(map(len, fronts)))
        surfaces = moocore.eaf(
            points, sets, percentiles=[level for level, _, _ in _ATTAINMENT_SURFACES]
        )
        surfaces = surfaces[np.isfinite(surfaces).all(axis=1)]
        for level, meaning, width in _ATTAINMENT_SURFACES:
            surface = surfaces[surfaces[:, 2] == level, :2]
            surface = surface[np.argsort(surface[:, 0])]
            drawn.append(surface)
            line = {"color": trace_style.color, "dash": "1px,2px"}
            if level == 50:
                line = {"color": trace_style.color, "dash": trace_style.dash}
            style = {"mode": "lines", "line": {"shape": "hv", "width": width, **line}}
            trace = _build_points_trace(
                surface, name, f"{meaning} attained", comparison.objectives, **style
            )
            group = {"legendgroup": name, "showlegend": level == 50}
            figure.add_trace(trace.update(name=escape_markup(name), **group))
    set_axes(figure, comparison.objectives, np.concatenate(drawn))
    return apply_comparison_style(
        figure,
        "Empirical attainment surfaces",
        "thick: attained by half of the runs; dotted: attained by the best run and by every "
        f"run{CLICK_HINT}",
    )


def draw_attainment_difference(comparison: Comparison, first: str, second: str) -> go.Figure:
    """Draw a heat map that compares how often two algorithms attain each point.

    The color shows the difference in the share of runs that attain a point of the objective space,
    see `compute_attainment`.

    Raises
    ------
    ValueError
        Unless there are two objectives, both algorithms have a finished run, and a run has a front.
    """
    validate_n_objectives(comparison.problem, 2)
    fronts_of_pair = [comparison.list_fronts(name) for name in (first, second)]
    fronts = [front for runs in fronts_of_pair for front in runs if len(front)]
    if not (all(fronts_of_pair) and fronts):
        raise ValueError(
            f"{first!r} and {second!r}: expected a finished run of each algorithm, and one front"
        )
    points = np.concatenate(fronts)
    x, y = (_compute_cell_edges(values) for values in points.T)
    shares = [compute_attainment(runs, x[:-1], y[:-1]) for runs in fronts_of_pair]
    figure = go.Figure(
        go.Heatmap(
            x=x,
            y=y,
            z=np.round(100.0 * (shares[0] - shares[1])).astype(np.int8),
            coloraxis="coloraxis",
            hovertemplate=f"{escape_markup(first)} minus {escape_markup(second)}: %{{z}} %"
            "<extra></extra>",
        )
    )
    set_axes(figure, comparison.objectives, points)
    figure.update_coloraxes(
        cmin=-100,
        cmax=100,
        colorscale=[(0.0, "#be4b00"), (0.5, "#ffffff"), (1.0, "#005c94")],
        colorbar={"title": {"text": "difference in<br>share of runs"}, "ticksuffix": " %"},
    )
    return apply_comparison_style(
        figure,
        f"Attainment of {escape_markup(first)} against {escape_markup(second)}",
        f"blue: {escape_markup(first)} attains the point in more of its runs; orange: in fewer; "
        "stronger colors: larger difference",
    )


def compute_attainment(fronts: list[FloatArray], x: FloatArray, y: FloatArray) -> FloatArray:
    """Return the share of fronts that attain each point of a grid in objective space.

    A front attains a grid point if one of its points weakly dominates the grid point.

    Parameters
    ----------
    fronts : list of arrays, shape (n, 2)
        Objectives of each front.
    x, y : array
        Values of the first and second objective on the grid.

    Returns
    -------
    array, shape (len(y), len(x))
    """
    attained = np.zeros((len(y), len(x)))
    for front in fronts:
        order = front[np.argsort(front[:, 0])]
        lowest = np.concatenate([[np.inf], np.minimum.accumulate(order[:, 1])])
        attained += lowest[np.searchsorted(order[:, 0], x, side="right")] <= y[:, None]
    return attained / len(fronts)


def _compute_cell_edges(values: FloatArray) -> FloatArray:
    """Return heat-map cell edges at the distinct values, or at quantiles if there are many."""
    edges = np.unique(values)
    if len(edges) > _MAX_CELLS:
        edges = np.unique(np.quantile(edges, np.linspace(0.0, 1.0, _MAX_CELLS), method="nearest"))
    return np.append(edges, edges[-1] + 0.05 * (np.ptp(edges) or 1.0))


def _build_points_trace(
    F: FloatArray, name: str, run: str, objectives: tuple[str, ...], **style: Any
) -> go.Scatter | go.Scatter3d:
    axes = zip(objectives, _COORDINATES, strict=False)
    lines = [f"{escape_markup(title)}: %{{{key}:.6g}}" for title, key in axes]
    hover = "<br>".join([f"<b>{escape_markup(name)}</b>, {run}", *lines]) + "<extra></extra>"
    coordinates = dict(zip(_COORDINATES, F.T, strict=False))
    kind = go.Scatter3d if F.shape[1] == 3 else go.Scatter
    return kind(**coordinates, hovertemplate=hover, **style)
