"""What each phase of a plan bought: the 1-sigma that is left at its end."""

from __future__ import annotations

import numpy as np
import pandas as pd
import plotly.graph_objects as go

from ..describe import BlockUnit
from .style import COLORS, DASHES, SYMBOLS, finished

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
            line={
                "color": COLORS[index % len(COLORS)],
                "dash": DASHES[index % len(DASHES)],
                "width": 2,
            },
            marker={"symbol": SYMBOLS[index % len(SYMBOLS)], "size": 9},
            customdata=values,
            hovertemplate=f"{block.label} %{{customdata:.4g}} {block.unit} (%{{y:.3g}})",
        )
    finished(
        figure,
        "1-sigma at the end of each phase, over the initial one",
        "worst body axis of each error",
    )
    decades = np.log10(worst.max() / worst.min()) > 1.5
    figure.update_layout(hovermode="x unified", height=460)
    figure.update_yaxes(
        type="log",
        title_text="1-sigma / initial 1-sigma [-]",
        exponentformat="power",
        dtick=1 if decades else "D2",
    )
    return figure
