"""Figures of one plan."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go

from ..describe import block_units
from ..figures.correlation import correlation_figure
from ..figures.gains import gains_figure
from ..figures.maneuvers import maneuvers_figure
from ..figures.solutions import Solutions
from .plan import ManeuverPlan


def plan_figures(plan: ManeuverPlan) -> dict[str, go.Figure]:
    """Figures ``rates`` (against time), ``gains`` (1-sigma by phase) and ``correlation``."""
    solution = Solutions(
        numbers=np.zeros(1, dtype=np.int64),
        X=np.array([plan.design]),
        F=np.array([[plan.t_end, plan.trace]]),
        labels=("plan",),
    )
    return {
        "rates": maneuvers_figure(plan.scenario, solution),
        "gains": gains_figure(plan.gains(), block_units(plan.problem.model.suite)),
        "correlation": correlation_figure(plan.correlations()),
    }
