"""How an indicator develops with the number of evaluations."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import plotly.graph_objects as go

from mgeo.figures.comparison.style import Look, finished, looks
from mgeo.studies.statistics import bootstrap_band

if TYPE_CHECKING:
    from mgeo._typing import FloatArray
    from mgeo.studies.comparison import Comparison


def anytime_figure(comparison: Comparison, indicator: str | None = None) -> go.Figure:
    """Mean over runs with a 95 % bootstrap band, against evaluations.

    A curve begins where all its runs have a finite value (an empty front has none but of the
    hypervolume). The axis is logarithmic where lower is better and all means are positive.

    Raises
    ------
    ValueError
        If the indicator is unknown.
    """
    chosen = comparison.indicator(indicator)
    figure = go.Figure()
    for name, look in looks(comparison.algorithms).items():
        rows = comparison.table[comparison.table["algorithm"] == name]
        wide = rows.pivot(index="seed", columns="evaluations", values=chosen.name)
        wide = wide.loc[:, np.isfinite(wide.to_numpy(float)).all(axis=0)]
        if wide.size:
            values = wide.to_numpy(float)
            figure.add_traces(_curve(name, look, wide.columns.to_numpy(int), values))
    figure.update_xaxes(title="evaluations", tickformat=",d", rangemode="tozero")
    positive = all(np.min(curve.y) > 0 for curve in figure.data if curve.mode == "lines")
    figure.update_yaxes(
        title=chosen.title,
        type="log" if positive and not chosen.larger else "linear",
        exponentformat="power",
    )
    better = "higher is better" if chosen.larger else "lower is better"
    return finished(
        figure,
        f"{chosen.title[0].upper()}{chosen.title[1:]} of all evaluations so far",
        f"mean of the runs, {better}; band: 95 % bootstrap interval of the mean; "
        "click the legend to hide",
    )


def _curve(name: str, look: Look, x: FloatArray, values: FloatArray) -> list[go.Scatter]:
    mean = values.mean(axis=0)
    low, high = bootstrap_band(values)
    texts = [
        f"<b>{name}</b><br>after {n:,} evaluations<br>mean of {len(values)} runs: {m:.5g}"
        f"<br>95 % interval: {a:.5g} to {b:.5g}"
        for n, m, a, b in zip(x, mean, low, high, strict=True)
    ]
    band = go.Scatter(
        x=np.concatenate([x, x[::-1]]),
        y=np.concatenate([high, low[::-1]]),
        fill="toself",
        fillcolor=look.faint(0.18),
        line={"width": 0},
        hoverinfo="skip",
        legendgroup=name,
        showlegend=False,
    )
    line = go.Scatter(
        x=x,
        y=mean,
        mode="lines",
        name=name,
        legendgroup=name,
        line={"color": look.color, "dash": look.dash, "width": 2},
        hovertext=texts,
        hoverinfo="text",
    )
    return [band, line]
