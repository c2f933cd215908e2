"""Why a plan leaves what it leaves, and what its sensors saw."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import Scenario
from mgeo_attitude.plan import ManeuverPlan

DESIGN = (0.4, -0.2, 0.1, 300.0, 0.3, 0.5, -0.4, 200.0, -0.6, 0.1, 0.2, 100.0)


@pytest.fixture(scope="module")
def plan():
    changes = {"eclipse": True, "duration": 2400.0, "step": 4.0}
    scenario = dataclasses.replace(Scenario.paper(), **changes)
    end = dataclasses.replace(scenario.convergence, rule="settling", factor=1.0 + 1e-9)
    return ManeuverPlan(dataclasses.replace(scenario, convergence=end), DESIGN)


def test_squares_add_up_to_the_worst_axis(plan):
    table = plan.budget()
    parts, whole = table.iloc[:-1].to_numpy(), table.loc["all"].to_numpy()
    np.testing.assert_allclose((parts**2).sum(axis=0), whole**2, rtol=1e-12)
    worst = plan.accuracy()["after"].to_numpy().reshape(-1, 3).max(axis=1)
    np.testing.assert_allclose(whole, worst, rtol=1e-9)


def test_the_largest_part_is_told_first_and_the_limits_word_on_it(plan):
    (line,) = plan.reasons()
    parts = plan.budget().iloc[:-1, 0]
    assert line.startswith("attitude ")
    assert f": {parts.max():.3g} {parts.idxmax()}, " in line
    if parts.idxmax().startswith("initial "):
        assert "no maneuver can leave less than" in line


def test_in_the_shadow_no_second_of_a_sun_sensor_is_counted(plan):
    use = plan.sensor_use()
    assert use["duration [s]"].sum() == pytest.approx(plan.t_end)
    sunlit = plan.problem.environment.sunlit[1 : len(plan.history.times)].sum() * 4.0
    assert use["sun [s]"].sum() == pytest.approx(sunlit)
    assert 0.0 < sunlit < plan.t_end
    assert (use["mag [s]"] == use["duration [s]"]).all()
