"""The fronts themselves: of typical runs together, and of every algorithm by themselves."""

from __future__ import annotations

from math import ceil
from typing import TYPE_CHECKING, Any

import numpy as np
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from mgeo.figures.front import axis
from mgeo.figures.style import literal
from mgeo.studies.figures.style import Look, finished, looks, require_objectives, set_axes

if TYPE_CHECKING:
    from mgeo._typing import FloatArray
    from mgeo.studies.results import Results

_COLUMNS = 3
_ROW_HEIGHT = 300


def fronts_figure(results: Results) -> go.Figure:
    """Of each algorithm the run with the median indicator, for two or three objectives.

    Raises
    ------
    ValueError
        For one objective, or more.
    """
    require_objectives(results.problem, 2, 3)
    figure, drawn = go.Figure(), [np.empty((0, results.problem.n_obj))]
    for name, look in looks(results.algorithms).items():
        seed = results.median_seed(name)
        if seed is None:
            continue
        F = results.records[name, seed].front_F
        F = F[np.lexsort(F.T[::-1])]
        drawn.append(F)
        figure.add_trace(_front(F, literal(f"{name}, seed {seed}"), look, results.objectives))
    everything = np.concatenate(drawn)
    if results.problem.n_obj == 2:
        set_axes(figure, results.objectives, everything)
    else:
        axes = zip(("xaxis", "yaxis", "zaxis"), results.objectives, everything.T, strict=True)
        figure.update_scenes({key: axis(name, values, in_space=True) for key, name, values in axes})
    return finished(
        figure,
        "Fronts of typical runs",
        f"of each algorithm the run with the median {results.indicator().title}: the nondominated "
        f"among all its {results.n_eval:,} evaluations",
    )


def each_figure(results: Results) -> go.Figure:
    """One picture per algorithm on equal axes: all runs in gray, the median one in color.

    Raises
    ------
    ValueError
        Unless there are two objectives.
    """
    require_objectives(results.problem, 2)
    names = [name for name in results.algorithms if any(map(len, results.fronts(name)))]
    rows = ceil(len(names) / _COLUMNS)
    figure = make_subplots(
        rows=rows,
        cols=_COLUMNS,
        shared_xaxes="all",
        shared_yaxes="all",
        subplot_titles=list(map(literal, names)),
        vertical_spacing=0.25 / rows,
        horizontal_spacing=0.07,
        x_title=literal(results.objectives[0]),
        y_title=literal(results.objectives[1]),
    )
    style = looks(results.algorithms)
    drawn = [np.concatenate(results.fronts(name)) for name in names]
    for i, (name, fronts) in enumerate(zip(names, drawn, strict=True)):
        place = {"row": i // _COLUMNS + 1, "col": i % _COLUMNS + 1}
        one_of = f"one of {len(results.fronts(name))} runs"
        gray = {"size": 3, "color": "#b5b5b5"}
        figure.add_trace(_points(fronts, gray, name, one_of), **place)
        seed = results.median_seed(name)
        if seed is not None:
            F = results.records[name, seed].front_F
            marker = {"size": 5, "color": style[name].color}
            figure.add_trace(_points(F, marker, name, f"seed {seed}"), **place)
    set_axes(figure, ("", ""), np.concatenate(drawn))
    figure.update_xaxes(showticklabels=True)
    figure.update_yaxes(showticklabels=True)
    title = results.indicator().title
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
