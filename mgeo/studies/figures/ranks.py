"""Algorithms over several problems: their average ranks, and how soon they reach targets."""

from __future__ import annotations

from typing import TYPE_CHECKING

import plotly.graph_objects as go

from mgeo.figures.style import CLICK, literal
from mgeo.studies.figures.style import finished, looks, row_height
from mgeo.studies.results import SHORTFALLS

if TYPE_CHECKING:
    import pandas as pd

    from mgeo.studies.statistics import Friedman


def ranks_figure(ranked: Friedman, algorithms: tuple[str, ...]) -> go.Figure:
    """Critical-difference diagram over problems (Demsar 2006).

    Parameters
    ----------
    algorithms : in the order that gives them their looks.
    """
    names, ranks = list(ranked.ranks.index), ranked.ranks.to_numpy(float)
    style = looks(algorithms)
    over = f"{ranked.problems} problems"
    if ranked.blocks < ranked.problems:
        over += f" of {ranked.blocks} functions"
    groups = alike(list(ranks), ranked.critical_difference)
    figure = go.Figure()
    for row, (low, high) in enumerate(groups):
        members = literal(", ".join(names[low : high + 1]))
        figure.add_scatter(
            x=[ranks[low], (ranks[low] + ranks[high]) / 2, ranks[high]],
            y=[0.6 + 0.45 * row] * 3,
            mode="lines",
            line={"width": 6, "color": "#8a8a8a"},
            text=f"not significantly different at 5 %:<br>{members}",
            hoverinfo="text",
        )
    for i, (name, rank) in enumerate(zip(names, ranks, strict=True)):
        look = style[name]
        figure.add_scatter(
            x=[rank, rank],
            y=[0, -1 - i],
            mode="lines+markers",
            line={"width": 1, "color": look.faint(0.5)},
            marker={"size": [0, 12], "color": look.color, "symbol": look.symbol, "opacity": 1},
            hovertext=f"<b>{literal(name)}</b><br>average rank {rank:.3f} over {over}",
            hoverinfo="text",
        )
    k = len(names)
    figure.update_xaxes(title="average rank (1 is the best)", range=[0.8, k + 0.2], dtick=1)
    figure.update_yaxes(
        range=[-k - 0.6, 0.8 + 0.45 * max(1, len(groups))],
        tickvals=[-1 - i for i in range(k)],
        ticktext=[
            f"{literal(name)}  <b>{rank:.2f}</b>" for name, rank in zip(names, ranks, strict=True)
        ],
        automargin=True,
    )
    return finished(
        figure,
        f"Average ranks over {over}",
        f"bars join what differs by less than the critical difference of "
        f"{ranked.critical_difference:.2f} (Nemenyi, 5 %); Friedman's test: p = {ranked.p:.2g}",
    ).update_layout(showlegend=False, height=row_height(k + len(groups)))


def alike(ranks: list[float], difference: float) -> list[tuple[int, int]]:
    """First and last of each largest group within the difference, ranks ascending."""
    groups: list[tuple[int, int]] = []
    for low, rank in enumerate(ranks):
        high = max(i for i, other in enumerate(ranks) if other - rank < difference)
        if high > low and (not groups or high > groups[-1][1]):
            groups.append((low, high))
    return groups


def targets_figure(reached: pd.DataFrame, n_problems: int) -> go.Figure:
    """Empirical distribution of runtimes, as COCO's users know it.

    Parameters
    ----------
    reached : as of `mgeo.studies.results.targets_reached`.
    n_problems : how many problems it is of.
    """
    figure = go.Figure()
    for name, look in looks(tuple(reached["algorithm"].unique())).items():
        steps = reached[reached["algorithm"] == name]
        figure.add_scatter(
            x=steps["evaluations"],
            y=steps["share"],
            mode="lines+markers",  # at the budgets that were measured
            line={"color": look.color, "dash": look.dash, "width": 2},
            marker={"symbol": look.symbol, "size": 6},
            name=literal(name),
            hovertemplate=f"<b>{literal(name)}</b><br>%{{y:.1%}} of the targets<br>"
            "within %{x:,.4g} evaluations per variable<extra></extra>",
        )
    figure.update_xaxes(title="evaluations per variable", type="log")
    figure.update_yaxes(title="share of targets reached", range=[0, 1], tickformat=".0%")
    return finished(
        figure,
        f"Targets reached, {n_problems} problems",
        f"targets: hypervolumes short of a problem's best by {SHORTFALLS[0]:.0%} to "
        f"{SHORTFALLS[-1]:.3%} of it{CLICK}",
    )
