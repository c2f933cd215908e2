"""How the final values of all indicators scatter over the runs."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from mgeo.figures.comparison.style import finished, looks, row_height
from mgeo.figures.front import axis

if TYPE_CHECKING:
    import pandas as pd

    from mgeo.studies.comparison import Comparison


def boxes_figure(comparison: Comparison) -> go.Figure:
    """A box of each algorithm for each indicator, with the runs as points."""
    indicators = comparison.indicators
    figure = make_subplots(rows=1, cols=len(indicators), shared_yaxes=True)
    final = comparison.final()
    for name, look in looks(comparison.algorithms).items():
        rows = final[final["algorithm"] == name]
        for column, indicator in enumerate(indicators, 1):
            values = rows[indicator.name].to_numpy(float)
            shown = np.isfinite(values)
            box = go.Box(
                x=values[shown],
                name=name,
                orientation="h",
                boxpoints="all",
                jitter=0.5,
                pointpos=0,
                marker={"color": look.color, "size": 4, "opacity": 0.7},
                line={"width": 1.2},
                fillcolor=look.faint(0.2),
                hovertext=[
                    f"<b>{name}</b>, seed {seed}<br>{indicator.title}: {value:.5g}"
                    for seed, value in zip(rows["seed"][shown], values[shown], strict=True)
                ],
                hoverinfo="text",
                hoveron="points",
                showlegend=False,
            )
            figure.add_trace(box, row=1, col=column)
    for column, indicator in enumerate(indicators, 1):
        values = final[indicator.name].to_numpy(float)
        figure.update_xaxes(axis("", values[np.isfinite(values)]), col=column)
        direction = "higher is better" if indicator.larger else "lower is better"
        figure.update_xaxes(title=f"{indicator.title}<br>{direction}", col=column)
    figure.update_xaxes(tickangle=0)
    figure.update_yaxes(autorange="reversed", automargin=True)
    return finished(
        figure,
        f"All runs after {comparison.n_eval:,} evaluations",
        f"box: quartiles and median; every point is a run, hover for its seed{_unseen(final)}",
    ).update_layout(height=row_height(len(comparison.algorithms)))


def _unseen(final: pd.DataFrame) -> str:
    runs = int((final["points"] == 0).sum())
    return f"; without {runs} that found nothing feasible" if runs else ""
