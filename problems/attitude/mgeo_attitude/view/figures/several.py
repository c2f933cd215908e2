"""All figures of a set of solutions."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import plotly.graph_objects as go

from mgeo.runs import knee
from mgeo_attitude.criteria.objectives import indicators
from mgeo_attitude.scenario.settings import PAPER
from mgeo_attitude.view import at_best
from mgeo_attitude.view.figures.against_time import convergence_figure, maneuvers_figure
from mgeo_attitude.view.figures.front import front_figure
from mgeo_attitude.view.figures.style import Solutions
from mgeo_attitude.view.plans import Plans, spread


def figures(plans: Plans) -> dict[str, go.Figure]:
    """Figures ``front``, ``maneuvers`` and ``convergence``; the latter two of up to six solutions.

    Solutions are numbered by their row. Those whose covariance broke down are left out.
    There is no ``front`` of a problem with other objectives than the paper's: it shows these.

    Raises
    ------
    ValueError
        If there is no plan with finite objectives.
    """
    problem, solutions = plans.problem, Solutions.of(plans)
    ends = [problem.n_obj, problem.n_obj + problem.n_ieq_constr]
    own, excess, _ = np.split(plans.values[solutions.numbers], ends, axis=1)
    bend = knee(indicators(problem.objectives, own, problem.scenario))
    few = solutions.chosen(bend)
    front = {}
    if problem.objectives == PAPER:
        rows = spread(len(solutions.X))
        looked_at = plans.take(solutions.numbers[rows])
        known = np.full((len(own), 3), np.nan)
        known[rows] = np.column_stack([looked_at.kept, looked_at.kept_sigma_deg])
        by_design = problem.model.rule == "end"  # and not because too few converge
        longest = math.inf if by_design else problem.model.longest
        known[known[:, 0] >= longest] = np.nan  # so many flights do not converge at all
        front["front"] = front_figure(
            problem.scenario,
            dataclasses.replace(solutions, F=own),
            known,
            longest=longest,
            dead_end=bool((excess > 0.0).any(axis=1).all()),
            least=at_best.under(problem, own[:, 0]),
            bend=bend,
        )
    return front | {
        "maneuvers": maneuvers_figure(problem, few, plans.held_until[few.numbers]),
        "convergence": convergence_figure(problem, few),
    }
