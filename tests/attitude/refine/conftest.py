"""Fixtures: short problems whose plans are improved."""

import dataclasses

import pytest
from mgeo_attitude import AttitudeManeuverProblem, Scenario
from mgeo_attitude.scenario import Convergence


def build_short_problem(count, rule, **more):
    """Return the paper's problem for 1,200 s with a coarser step."""
    scenario = dataclasses.replace(
        Scenario.paper(),
        duration=1200.0,
        step=2.0,
        convergence=Convergence(rule=rule, window=100.0, relative_decrease=0.05),
        **more,
    )
    return AttitudeManeuverProblem(scenario, n_maneuvers=count)


@pytest.fixture(scope="module")
def problem(request):
    """Problem with four maneuvers that ends with the last one, or by another convergence rule."""
    return build_short_problem(4, getattr(request, "param", "end"))


parametrize_rule = pytest.mark.parametrize("problem", ["trace", "end"], indirect=True)
