"""``mgeo attitude check``."""

from __future__ import annotations

import numpy as np

from mgeo_attitude.filter.reference import Agreement, agreement
from mgeo_attitude.problem import AttitudeManeuverProblem
from mgeo_attitude.scenario import Scenario

#: Largest relative difference of a variance between the two filters.
TOLERANCE = 1e-9


def compare_filters(scenario: Scenario, plans: int, seed: int) -> Agreement:
    """Both filters on random plans of a scenario."""
    problem, rng = AttitudeManeuverProblem(scenario), np.random.default_rng(seed)
    designs = rng.uniform(problem.xl, problem.xu, (plans, problem.n_var))
    if problem.start_times is not None:  # all from the first: another one is another epoch
        designs, _ = problem.start_times.split(designs)
    return agreement(problem.model, designs)


def agrees(found: Agreement) -> bool:
    return found.same_end and found.difference <= TOLERANCE


def conclusion(scenario: Scenario, found: Agreement) -> str:
    """In a line."""
    ends = "every t_end the same" if found.same_end else "NOT every t_end the same"
    return (
        f"{scenario.name}: {found.designs} random plans, {found.samples:,} samples: {ends}, "
        f"variances differ by {found.difference:.2g} of their size at most, "
        f"{TOLERANCE:g} allowed"
    )
