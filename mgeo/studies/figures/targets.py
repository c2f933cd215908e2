"""What share of targets is reached how soon, over all problems."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
import plotly.graph_objects as go

from mgeo.figures.style import CLICK
from mgeo.studies.figures.style import finished, looks
from mgeo.studies.targets import SHORTFALLS, runtimes

if TYPE_CHECKING:
    from mgeo.studies.results import Results


def targets_figure(results: Mapping[str, Results]) -> go.Figure | None:
    """Empirical distribution of runtimes, as COCO's users know it; None without a hypervolume.

    The share of all targets (see `mgeo.studies.targets`), of all runs on all problems, that are
    reached within so many evaluations per variable.
    """
    times = runtimes(results)
    if not times:
        return None
    figure = go.Figure()
    for name, look in looks(tuple(times)).items():
        reached = times[name][np.isfinite(times[name])]
        x, last = np.unique(reached, return_index=True)
        share = np.append(last[1:], len(reached)) / len(times[name])
        figure.add_scatter(
            x=x,
            y=share,
            mode="lines",
            line={"shape": "hv", "color": look.color, "dash": look.dash, "width": 2},
            name=name,
            hovertemplate=f"<b>{name}</b><br>%{{y:.1%}} of the targets<br>within %{{x:,.4g}} "
            "evaluations per variable<extra></extra>",
        )
    figure.update_xaxes(title="evaluations per variable", type="log")
    figure.update_yaxes(title="share of targets reached", range=[0, 1], tickformat=".0%")
    return finished(
        figure,
        f"Targets reached, {len(results)} problems",
        f"targets: hypervolumes short of a problem's best by {SHORTFALLS[0]:.0%} to "
        f"{SHORTFALLS[-1]:.3%} of it{CLICK}",
    )
