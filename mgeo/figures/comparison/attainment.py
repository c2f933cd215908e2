"""Empirical attainment: what part of the runs reaches how far."""

from __future__ import annotations

from typing import TYPE_CHECKING

import moocore
import numpy as np
import plotly.graph_objects as go

from mgeo.figures.comparison.style import finished, looks
from mgeo.figures.front import axis

if TYPE_CHECKING:
    from mgeo._typing import FloatArray
    from mgeo.studies.comparison import Comparison

_LEVELS = ((50, "half of the runs", 2.0), (0, "the best run", 1.0), (100, "every run", 1.0))


def attainment_figure(comparison: Comparison) -> go.Figure:
    """Of each algorithm the surfaces that one run, half of them and all of them attain.

    Raises
    ------
    ValueError
        Unless there are two objectives.
    """
    _require_two(comparison)
    figure, drawn = go.Figure(), [np.empty((0, 2))]
    for name, look in looks(comparison.algorithms).items():
        points, sets = stacked(comparison.fronts(name))
        if not np.isfinite(points).any():
            continue
        surfaces = moocore.eaf(points, sets, percentiles=[level for level, _, _ in _LEVELS])
        surfaces = surfaces[np.isfinite(surfaces).all(axis=1)]
        for level, meaning, width in _LEVELS:
            surface = surfaces[surfaces[:, 2] == level, :2]
            surface = surface[np.argsort(surface[:, 0])]
            drawn.append(surface)
            figure.add_trace(
                go.Scatter(
                    x=surface[:, 0],
                    y=surface[:, 1],
                    mode="lines",
                    line={
                        "shape": "hv",
                        "width": width,
                        "color": look.color if level == 50 else look.faint(0.6),
                        "dash": look.dash if level == 50 else "1px,2px",
                    },
                    name=name,
                    legendgroup=name,
                    showlegend=level == 50,
                    hovertemplate=f"<b>{name}</b><br>{meaning} attained<br>%{{x:.6g}}, %{{y:.6g}}"
                    "<extra></extra>",
                )
            )
    everything = np.concatenate(drawn)
    for update, i in ((figure.update_xaxes, 0), (figure.update_yaxes, 1)):
        update(axis(comparison.objectives[i], everything[:, i]))
    return finished(
        figure,
        "Empirical attainment surfaces",
        "thick: what half of the runs dominate or reach; dotted: the best run and every run; "
        "click the legend to hide",
    )


def stacked(fronts: list[FloatArray]) -> tuple[FloatArray, FloatArray]:
    """All points below each other, shape (n, 2), and the number of the front of each, (n,).

    An empty front is a point at infinity: a run that counts, and attains nothing.
    """
    counted = [front if len(front) else np.full((1, 2), np.inf) for front in fronts]
    numbers = np.repeat(np.arange(1.0, len(counted) + 1), [len(front) for front in counted])
    return np.concatenate([np.empty((0, 2)), *counted]), numbers


def _require_two(comparison: Comparison) -> None:
    if comparison.problem.n_obj != 2:
        raise ValueError(
            f"{comparison.problem.n_obj} objectives: attainment is drawn for two of them"
        )
