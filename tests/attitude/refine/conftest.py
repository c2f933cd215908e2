"""Short problems to make plans better for."""

import dataclasses

import pytest
from mgeo_attitude import AttitudeManeuverProblem, Scenario
from mgeo_attitude.scenario import Convergence


def short(count, rule, **more):
    """The paper's satellite for 1,200 s, with a coarser step."""
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
    """A problem that ends with its maneuvers, or by another rule of convergence."""
    return short(4, getattr(request, "param", "end"))


by_each_rule = pytest.mark.parametrize("problem", ["trace", "end"], indirect=True)
