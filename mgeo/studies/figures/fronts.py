"""Fronts of typical runs and of every algorithm, and empirical attainment.

That is what part of the runs reaches how far, and where two algorithms differ.
"""

from __future__ import annotations

from math import ceil
from typing import TYPE_CHECKING, Any

import moocore
import numpy as np
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from mgeo.figures.front import axis
from mgeo.figures.style import CLICK, literal
from mgeo.studies.figures.style import Look, finished, looks, require_objectives, set_axes

if TYPE_CHECKING:
    from mgeo._typing import FloatArray
    from mgeo.studies.comparison import Comparison

_COLUMNS = 3
_ROW_HEIGHT = 300


def fronts_figure(comparison: Comparison) -> go.Figure:
    """Of each algorithm the run with the median indicator, for two or three objectives.

    Raises
    ------
    ValueError
        For one objective, or more.
    """
    require_objectives(comparison.problem, 2, 3)
    figure, drawn = go.Figure(), [np.empty((0, comparison.problem.n_obj))]
    for name, look in looks(comparison.algorithms).items():
        seed = comparison.median_seed(name)
        if seed is None:
            continue
        F = comparison.records[name, seed].front_F
        F = F[np.lexsort(F.T[::-1])]
        drawn.append(F)
        figure.add_trace(_front(F, literal(f"{name}, seed {seed}"), look, comparison.objectives))
    everything = np.concatenate(drawn)
    if comparison.problem.n_obj == 2:
        set_axes(figure, comparison.objectives, everything)
    else:
        axes = zip(("xaxis", "yaxis", "zaxis"), comparison.objectives, everything.T, strict=True)
        figure.update_scenes({key: axis(name, values, in_space=True) for key, name, values in axes})
    return finished(
        figure,
        "Fronts of typical runs",
        f"of each algorithm the run with the median {comparison.indicator().title}: the "
        f"nondominated among all its {comparison.n_eval:,} evaluations",
    )


def each_figure(comparison: Comparison) -> go.Figure:
    """One picture per algorithm on equal axes: all runs in gray, the median one in color.

    Raises
    ------
    ValueError
        Unless there are two objectives.
    """
    require_objectives(comparison.problem, 2)
    names = [name for name in comparison.algorithms if any(map(len, comparison.fronts(name)))]
    rows = ceil(len(names) / _COLUMNS)
    figure = make_subplots(
        rows=rows,
        cols=_COLUMNS,
        shared_xaxes="all",
        shared_yaxes="all",
        subplot_titles=list(map(literal, names)),
        vertical_spacing=0.25 / rows,
        horizontal_spacing=0.07,
        x_title=literal(comparison.objectives[0]),
        y_title=literal(comparison.objectives[1]),
    )
    style = looks(comparison.algorithms)
    drawn = [np.concatenate(comparison.fronts(name)) for name in names]
    for i, (name, fronts) in enumerate(zip(names, drawn, strict=True)):
        place = {"row": i // _COLUMNS + 1, "col": i % _COLUMNS + 1}
        one_of = f"one of {len(comparison.fronts(name))} runs"
        gray = {"size": 3, "color": "#b5b5b5"}
        figure.add_trace(_points(fronts, gray, name, one_of), **place)
        seed = comparison.median_seed(name)
        if seed is not None:
            F = comparison.records[name, seed].front_F
            marker = {"size": 5, "color": style[name].color}
            figure.add_trace(_points(F, marker, name, f"seed {seed}"), **place)
    set_axes(figure, ("", ""), np.concatenate(drawn))
    figure.update_xaxes(showticklabels=True)
    figure.update_yaxes(showticklabels=True)
    title = comparison.indicator().title
    finished(
        figure,
        "Fronts one by one",
        f"gray: all runs; in color: the run with the median {title}; equal axes, zoomed together",
    )
    return figure.update_layout(height=180 + _ROW_HEIGHT * rows, showlegend=False)


def _front(F: FloatArray, name: str, look: Look, objectives: tuple[str, ...]) -> Any:
    texts = [
        f"<b>{name}</b><br>"
        + "<br>".join(f"{literal(o)}: {v:.6g}" for o, v in zip(objectives, f, strict=True))
        for f in F
    ]
    shared = {"mode": "markers", "name": name, "hovertext": texts, "hoverinfo": "text"}
    if F.shape[1] == 3:
        marker = {"size": 3, "color": look.color}
        return go.Scatter3d(x=F[:, 0], y=F[:, 1], z=F[:, 2], marker=marker, **shared)
    marker = {"size": 6, "color": look.color, "symbol": look.symbol, "opacity": 0.8}
    shared["mode"] = "lines+markers"
    line = {"shape": "hv", "width": 1, "color": look.faint(0.5), "dash": look.dash}
    return go.Scatter(x=F[:, 0], y=F[:, 1], marker=marker, line=line, **shared)


def _points(F: FloatArray, marker: dict[str, object], name: str, run: str) -> go.Scatter:
    hover = f"<b>{literal(name)}</b>, {run}<br>%{{x:.6g}}, %{{y:.6g}}<extra></extra>"
    return go.Scatter(x=F[:, 0], y=F[:, 1], mode="markers", marker=marker, hovertemplate=hover)


_SURFACES = ((50, "half of the runs", 2.0), (0, "the best run", 1.0), (100, "every run", 1.0))
_STEPS = 5  # of the difference in share of runs, in each direction
_LEVELS = (*range(_STEPS, 0, -1), *range(-1, -_STEPS - 1, -1))
_FIRST, _SECOND = (0, 92, 148), (190, 75, 0)  # at their strongest


def attainment_figure(comparison: Comparison) -> go.Figure:
    """Of each algorithm the surfaces that one run, half of them and all of them attain.

    Raises
    ------
    ValueError
        Unless there are two objectives.
    """
    require_objectives(comparison.problem, 2)
    figure, drawn = go.Figure(), [np.empty((0, 2))]
    for name, look in looks(comparison.algorithms).items():
        points, sets = _stacked(comparison.fronts(name))
        if not np.isfinite(points).any():
            continue
        surfaces = moocore.eaf(points, sets, percentiles=[level for level, _, _ in _SURFACES])
        surfaces = surfaces[np.isfinite(surfaces).all(axis=1)]
        for level, meaning, width in _SURFACES:
            surface = surfaces[surfaces[:, 2] == level, :2]
            surface = surface[np.argsort(surface[:, 0])]
            drawn.append(surface)
            figure.add_scatter(
                x=surface[:, 0],
                y=surface[:, 1],
                mode="lines",
                line={
                    "shape": "hv",
                    "width": width,
                    "color": look.color if level == 50 else look.faint(0.6),
                    "dash": look.dash if level == 50 else "1px,2px",
                },
                name=literal(name),
                legendgroup=name,
                showlegend=level == 50,
                hovertemplate=f"<b>{literal(name)}</b><br>{meaning} attained<br>"
                "%{x:.6g}, %{y:.6g}<extra></extra>",
            )
    set_axes(figure, comparison.objectives, np.concatenate(drawn))
    return finished(
        figure,
        "Empirical attainment surfaces",
        "thick: what half of the runs dominate or reach; dotted: the best run and every "
        f"run{CLICK}",
    )


def difference_figure(comparison: Comparison, first: str, seconds: list[str]) -> go.Figure:
    """Differences of the attainment of one algorithm and of each of some others, on a menu.

    Raises
    ------
    ValueError
        Unless there are two objectives, and every algorithm has a finished run, one of each pair
        with a front.
    """
    require_objectives(comparison.problem, 2)
    pairs = []
    for second in seconds:
        ours, theirs = comparison.fronts(first), comparison.fronts(second)
        runs = min(len(ours), len(theirs))  # moocore expects equal numbers
        pairs.append((ours[:runs], theirs[:runs]))
        if not any(map(len, ours[:runs] + theirs[:runs])):
            raise ValueError(
                f"{first!r} and {second!r}: expected a finished run of each, and a front"
            )
    everything = np.concatenate([front for ours, theirs in pairs for front in ours + theirs])
    corner = everything.max(axis=0) + 0.05 * np.ptp(everything, axis=0)
    figure = go.Figure()
    buttons = []
    for j, (second, (ours, theirs)) in enumerate(zip(seconds, pairs, strict=True)):
        areas = _areas(ours, theirs, corner)
        shares = [_share(abs(level), min(_STEPS, len(ours))) for level in _LEVELS]
        for level, share in zip(_LEVELS, shares, strict=True):
            sides = (first, second) if level > 0 else (second, first)
            figure.add_trace(_area(*sides, level, share, areas.get(level, [])))
            figure.data[-1].visible = j == 0 and bool(share)
        shown = [False] * len(_LEVELS) * len(pairs)
        shown[j * len(_LEVELS) : (j + 1) * len(_LEVELS)] = map(bool, shares)
        label = literal(f"{first} against {second}")
        buttons.append({"label": label, "method": "update", "args": [{"visible": shown}]})
    if len(seconds) > 1:
        place = {"x": 1.0, "xanchor": "right", "y": 1.02, "yanchor": "bottom"}
        menu = {"buttons": buttons, "direction": "down", "showactive": True, **place}
        figure.update_layout(updatemenus=[menu])
    set_axes(figure, comparison.objectives, everything)
    finished(
        figure,
        f"Where {literal(first)} attains more often, and where less",
        f"blue: {literal(first)} gets there in more of its runs than the other; orange: in fewer; "
        "the darker, the more",
    )
    return figure.update_layout(legend={"title": "difference in share of runs"})


def _stacked(fronts: list[FloatArray]) -> tuple[FloatArray, FloatArray]:
    """All points below each other, shape (n, 2), and the number of the front of each, (n,).

    An empty front is a point at infinity: a run that counts, and attains nothing.
    """
    counted = [front if len(front) else np.full((1, 2), np.inf) for front in fronts]
    numbers = np.repeat(np.arange(1.0, len(counted) + 1), [len(front) for front in counted])
    return np.concatenate([np.empty((0, 2)), *counted]), numbers


def _areas(
    first: list[FloatArray], second: list[FloatArray], corner: FloatArray
) -> dict[int, list[FloatArray]]:
    """Rectangles (x0, y0, x1, y1) of the plane by level of the difference, cut at a corner.

    Level k is a difference of k in min(`_STEPS`, runs), or up to the next.
    """
    sides = [_stacked(fronts) for fronts in (first, second)]
    if np.array_equal(*(moocore.eaf(points, sets) for points, sets in sides)):
        return {}  # moocore 0.3 cannot say that there is no difference
    found = moocore.eafdiff(
        *(np.column_stack(side) for side in sides),
        intervals=min(_STEPS, len(first)),
        rectangles=True,
    )
    found[:, 2:4] = np.minimum(found[:, 2:4], corner)
    found = found[(found[:, :2] < found[:, 2:4]).all(axis=1)]
    levels = found[:, 4].astype(int)
    return {level: list(found[levels == level, :4]) for level in _LEVELS}


def _share(level: int, steps: int) -> str:
    """What a level means in percent of the runs; nothing if there is no such level."""
    if level > steps:
        return ""
    low = f"{100 * level / steps:.3g}"
    return f"{low} %" if level == steps else f"{low} to {100 * (level + 1) / steps:.3g} %"


def _area(
    winner: str, loser: str, level: int, share: str, rectangles: list[FloatArray]
) -> go.Scatter:
    """One filled trace of all rectangles; an empty one keeps its place in the legend."""
    strength = abs(level) / _STEPS
    parts = [round(255 - strength * (255 - c)) for c in (_FIRST if level > 0 else _SECOND)]
    color = "rgb({},{},{})".format(*parts)
    x: list[float | None] = []
    y: list[float | None] = []
    for x0, y0, x1, y1 in rectangles:
        x += [x0, x1, x1, x0, x0, None]
        y += [y0, y0, y1, y1, y0, None]
    return go.Scatter(
        x=x or [None],
        y=y or [None],
        mode="lines",
        fill="toself",
        fillcolor=color,
        line={"width": 0.5, "color": color},  # closes the seams between rectangles
        name=literal(f"{winner}: {share}"),
        text=f"<b>{literal(winner)}</b> attains this in {share} more<br>of its runs than "
        f"{literal(loser)} does",
        hoverinfo="text",
        hoveron="fills",
    )
