"""What each phase of a plan bought: the 1-sigma that is left at its end."""

from __future__ import annotations

import pandas as pd
import plotly.graph_objects as go

from mgeo.figures.style import SYMBOLS, finished, log_axis

from ..describe import BlockUnit
from .style import line

_TRACE_AND_TIMES = 3  # columns before the states


def gains_figure(gains: pd.DataFrame, blocks: list[BlockUnit]) -> go.Figure:
    """One line per 3-vector of the state: its worst axis over what that was at the start.

    Parameters
    ----------
    gains : DataFrame
        Of `observability.gains`.
    blocks : list of BlockUnit
        Of `describe.block_units`, in the order of the state.
    """
    sigma = gains.iloc[:, _TRACE_AND_TIMES:].to_numpy(float).reshape(len(gains), len(blocks), 3)
    worst = sigma.max(axis=2)
    times = gains["time [s]"].to_numpy(float)
    ticks = [f"{name}<br>{time:.6g} s" for name, time in zip(gains.index, times, strict=True)]
    figure = go.Figure()
    for index, (block, values) in enumerate(zip(blocks, worst.T, strict=True)):
        figure.add_scatter(
            x=ticks,
            y=values / values[0],
            name=block.label,
            mode="lines+markers",
            line=line(index),
            marker={"symbol": SYMBOLS[index % len(SYMBOLS)], "size": 9},
            customdata=values,
            hovertemplate=f"{block.label} %{{customdata:.4g}} {block.unit} (%{{y:.3g}})",
        )
    finished(
        figure,
        "1-sigma at the end of each phase, over the initial one",
        "worst body axis of each error",
    )
    figure.update_layout(hovermode="x unified", height=460)
    figure.update_yaxes(log_axis(worst / worst[0]), title_text="1-sigma / initial 1-sigma [-]")
    return figure
