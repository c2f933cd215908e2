"""The fronts themselves: one typical run of each algorithm."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import plotly.graph_objects as go

from mgeo.figures.comparison.style import Look, finished, looks
from mgeo.figures.front import axis

if TYPE_CHECKING:
    from mgeo._typing import FloatArray
    from mgeo.studies.comparison import Comparison


def fronts_figure(comparison: Comparison) -> go.Figure:
    """Of each algorithm the run with the median indicator, for two or three objectives.

    Raises
    ------
    ValueError
        For one objective, or more.
    """
    n_obj = comparison.problem.n_obj
    if n_obj not in (2, 3):
        raise ValueError(f"{n_obj} objectives: expected 2 or 3 to draw fronts")
    figure, drawn = go.Figure(), [np.empty((0, n_obj))]
    for name, look in looks(comparison.algorithms).items():
        seed = comparison.median_seed(name)
        if seed is None:
            continue
        F = comparison.records[name, seed].front_F
        F = F[np.lexsort(F.T[::-1])]
        drawn.append(F)
        figure.add_trace(_front(F, f"{name}, seed {seed}", look, comparison.objectives))
    everything = np.concatenate(drawn)
    axes = [axis(n, v) for n, v in zip(comparison.objectives, everything.T, strict=True)]
    if n_obj == 2:
        figure.update_xaxes(axes[0])
        figure.update_yaxes(axes[1])
    else:
        figure.update_scenes(dict(zip(("xaxis", "yaxis", "zaxis"), axes, strict=True)))
    title = comparison.indicators[0].title
    return finished(
        figure,
        "Fronts of typical runs",
        f"of each algorithm the run with the median {title}: the nondominated among all its "
        f"{comparison.n_eval:,} evaluations",
    )


def _front(F: FloatArray, name: str, look: Look, objectives: tuple[str, ...]) -> Any:
    texts = [
        f"<b>{name}</b><br>"
        + "<br>".join(f"{o}: {v:.6g}" for o, v in zip(objectives, f, strict=True))
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
