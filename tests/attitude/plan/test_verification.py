"""The verdict on simulated flights: by hand, and of a real plan."""

import dataclasses

import numpy as np
import pandas as pd
import pytest
from mgeo_attitude import AttitudeManeuverProblem, Scenario
from mgeo_attitude.estimation import simulate
from mgeo_attitude.plan import ManeuverPlan, verification
from mgeo_attitude.plan.verification import Verification, verify


def judged(ratio=1.0, nees=1.0):
    table = pd.DataFrame({"rms / predicted [-]": [0.5, ratio]}, index=["attitude x", "sun bias y"])
    return Verification(200, table, 1.17, nees, (0.94, 1.06), pd.DataFrame())


def test_verdicts():
    assert judged().achieved
    assert judged(nees=0.5).achieved  # less sure than it might be does no harm
    assert not judged(nees=1.07).achieved
    assert not judged(ratio=1.18).achieved
    assert judged(ratio=1.18).worse == ["sun bias y"]


@pytest.fixture(scope="module")
def short_plan():
    scenario = dataclasses.replace(Scenario.paper(), duration=600.0)
    problem = AttitudeManeuverProblem(scenario)
    third = 150.0
    return ManeuverPlan.from_design(problem, [1.0, 0, 0, third, 0, 1.0, 0, third, 0, 0, 1.0, third])


@pytest.mark.slow
def test_a_real_plan(short_plan):
    found = verify(short_plan, n_runs=20, seed=3)
    same = simulate(short_plan.scenario, short_plan.design, 20, 3)
    at = same.sample()
    rms = np.sqrt((same.errors[:, at] ** 2).mean(axis=0))
    assert found.table.loc["mag bias z", "rms"] == pytest.approx(50e3 * rms[17], rel=1e-12)
    assert found.table.loc["attitude y", "rms"] == pytest.approx(np.degrees(rms[1]), rel=1e-12)
    np.testing.assert_allclose(found.table["predicted"], short_plan.accuracy()["after"], rtol=1e-6)
    assert found.nees == pytest.approx(same.nees[:, at].mean() / 18.0)
    # Wilson and Hilferty's approximation of the quantiles of chi square
    for bound, z in zip(found.nees_bounds, (-2.5758, 2.5758), strict=True):
        v = 2.0 / (9.0 * 360)
        assert bound == pytest.approx((1.0 - v + z * np.sqrt(v)) ** 3, abs=1e-4)


@pytest.mark.slow
def test_a_filter_that_is_promised_too_much_is_caught(short_plan, monkeypatch):
    """Truth with three times the Sun sensor's noise and bias."""
    sun, *others = short_plan.scenario.sensors
    worse = dataclasses.replace(sun, noise_deg=6.0, initial_bias=0.06)
    truth = dataclasses.replace(short_plan.scenario, sensors=(worse, *others))
    monkeypatch.setattr(
        verification,
        "simulate",
        lambda *arguments, **keywords: simulate(*arguments, truth=truth, **keywords),
    )
    found = verify(short_plan, n_runs=20)
    assert not found.achieved
    assert any(state.startswith("sun bias") for state in found.worse)


@pytest.mark.parametrize(
    ("keywords", "message"),
    [({"n_runs": 1}, "n_runs = 1: expected at least 2"), ({"seed": -1}, "seed = -1")],
)
def test_bad_arguments_are_named(short_plan, keywords, message):
    with pytest.raises(ValueError, match=message):
        verify(short_plan, **keywords)
