"""Every algorithm's fronts by themselves."""

from __future__ import annotations

from math import ceil
from typing import TYPE_CHECKING

import numpy as np
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from mgeo.figures.comparison.style import finished, looks
from mgeo.figures.front import axis

if TYPE_CHECKING:
    from mgeo._typing import FloatArray
    from mgeo.studies.comparison import Comparison

_COLUMNS = 3
_ROW_HEIGHT = 300


def each_figure(comparison: Comparison) -> go.Figure:
    """One picture per algorithm on equal axes: all runs in gray, the median one in color.

    Raises
    ------
    ValueError
        Unless there are two objectives.
    """
    if comparison.problem.n_obj != 2:
        raise ValueError(f"{comparison.problem.n_obj} objectives: expected 2")
    names = [name for name in comparison.algorithms if any(map(len, comparison.fronts(name)))]
    rows = ceil(len(names) / _COLUMNS)
    figure = make_subplots(
        rows=rows,
        cols=_COLUMNS,
        shared_xaxes="all",
        shared_yaxes="all",
        subplot_titles=names,
        vertical_spacing=0.25 / rows,
        horizontal_spacing=0.07,
        x_title=comparison.objectives[0],
        y_title=comparison.objectives[1],
    )
    style = looks(comparison.algorithms)
    for i, name in enumerate(names):
        place = {"row": i // _COLUMNS + 1, "col": i % _COLUMNS + 1}
        fronts = np.concatenate(comparison.fronts(name))
        seed = comparison.median_seed(name)
        runs = len(comparison.fronts(name))
        gray = {"size": 3, "color": "#b5b5b5"}
        all_of_them = f"<b>{name}</b>, one of {runs} runs<br>%{{x:.6g}}, %{{y:.6g}}<extra></extra>"
        figure.add_trace(_points(fronts, gray, all_of_them), **place)
        if seed is not None:
            F = comparison.records[name, seed].front_F
            marker = {"size": 5, "color": style[name].color}
            text = f"<b>{name}</b>, seed {seed}<br>%{{x:.6g}}, %{{y:.6g}}<extra></extra>"
            figure.add_trace(_points(F, marker, text), **place)
    everything = np.concatenate([f for name in names for f in comparison.fronts(name)])
    for update, i in ((figure.update_xaxes, 0), (figure.update_yaxes, 1)):
        update({**axis("", everything[:, i]), "showticklabels": True})
    title = comparison.indicators[0].title
    finished(
        figure,
        "Fronts one by one",
        f"gray: all runs; in color: the run with the median {title}; equal axes, zoomed together",
    )
    return figure.update_layout(height=180 + _ROW_HEIGHT * rows, showlegend=False)


def _points(F: FloatArray, marker: dict[str, object], hover: str) -> go.Scatter:
    return go.Scatter(x=F[:, 0], y=F[:, 1], mode="markers", marker=marker, hovertemplate=hover)
