"""What share of targets is reached how soon, over all problems."""

from __future__ import annotations

from typing import TYPE_CHECKING

import plotly.graph_objects as go

from mgeo.figures.style import CLICK, literal
from mgeo.studies.figures.style import finished, looks
from mgeo.studies.targets import SHORTFALLS

if TYPE_CHECKING:
    import pandas as pd


def targets_figure(reached: pd.DataFrame, n_problems: int) -> go.Figure:
    """Empirical distribution of runtimes, as COCO's users know it.

    Parameters
    ----------
    reached : as of `mgeo.studies.targets.targets_reached`.
    n_problems : how many problems it is of.
    """
    figure = go.Figure()
    for name, look in looks(tuple(reached["algorithm"].unique())).items():
        steps = reached[reached["algorithm"] == name]
        figure.add_scatter(
            x=steps["evaluations"],
            y=steps["share"],
            mode="lines",
            line={"shape": "hv", "color": look.color, "dash": look.dash, "width": 2},
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
