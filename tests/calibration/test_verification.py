"""Conclusions of a verification, from given results and for a real plan."""

import dataclasses

import numpy as np
import pandas as pd
import pytest
from mgeo_attitude import AttitudeManeuverProblem, Scenario
from mgeo_attitude.plan import ManeuverPlan
from mgeo_calibration import Verification, simulate, verification, verify
from mgeo_calibration.verification import compute_predictions, describe_failures, format_conclusion
from scipy.stats import chi2

from mgeo.studies.statistics import holm_correction

from ..three import three


def build_verification(predicted=1.0, claimed=1.0, p=(1.0, 1.0), nees_p=1.0, n=200):
    names = ["attitude x", "sun bias y"]
    columns = ("rms / predicted [-]", "rms / filter 1-sigma [-]", "p, predicted", "p, filter")
    rows = [[0.5, 0.5, 1.0, 1.0], [predicted, claimed, *p]]
    return Verification(n, pd.DataFrame(rows, names, columns), 1.2, nees_p, pd.DataFrame())


def test_conclusion_states_failed_tests():
    """One failed state is enough, against prediction or filter covariance, and so is the NEES."""
    achieved = build_verification(1.1)
    assert achieved.is_achieved
    assert "1.10 times its predicted 1-sigma (sun bias y)" in format_conclusion(achieved)
    known, unknown = (
        build_verification(1.3, 1.0, (0.001, 1.0)),
        build_verification(1.3, 1.25, (0.001, 0.002)),
    )
    assert not known.is_achieved
    assert not unknown.is_achieved
    assert (known.states_above_prediction, known.overconfident_states) == (["sun bias y"], [])
    for found, filter_note in ((known, "covers"), (unknown, "factor of 1.25")):
        (line,) = describe_failures(found)
        assert "sun bias (y) is 1.30 times its predicted 1-sigma" in line
        assert filter_note in line
        assert line in format_conclusion(found)
    (line,) = describe_failures(build_verification(nees_p=0.001))
    assert "overconfident by a factor of 1.10 over all states together" in line


@pytest.mark.parametrize("n_failed", [0, 2])
def test_thresholds_separate_failed_from_passed_tests(n_failed):
    """The p-values are those that Holm's method gives for the ratios."""
    n, m = 50, 18
    ratios = np.concatenate([np.linspace(1.5, 1.6, n_failed), np.linspace(0.9, 1.2, m - n_failed)])
    p = holm_correction(chi2.sf(n * np.concatenate([ratios, np.ones(m), [1.0]]) ** 2, n))
    table = pd.DataFrame(
        {
            "rms / predicted [-]": ratios,
            "rms / filter 1-sigma [-]": 1.0,
            "p, predicted": p[:m],
            "p, filter": p[m:-1],
        },
        index=[f"block{k} x" for k in range(m)],
    )
    found = Verification(n, table, 1.0, float(p[-1]), pd.DataFrame())
    assert found.find_failed_states() == list(table.index[ratios > found.max_ratio])
    assert len(found.find_failed_states()) == n_failed
    # A ratio slightly below the threshold passes, and one slightly above fails.
    for factor, fails in ((0.999, False), (1.001, True)):
        tail = chi2.sf(n * (factor * found.max_ratio) ** 2, n)
        assert (tail * (2 * m + 1 - n_failed) < 0.01) == fails


def test_detectable_ratio_has_declared_power():
    """Simulation: errors of this ratio fail nine of ten tests at the corrected level."""
    found = build_verification(n=50)
    z = np.random.default_rng(5).standard_normal((20_000, 50))
    p = chi2.sf((found.detectable_ratio * z**2 * found.detectable_ratio).sum(axis=1), 50)
    assert (p < 0.01 / 5).mean() == pytest.approx(0.9, abs=0.01)
    assert build_verification(n=200).detectable_ratio < found.detectable_ratio


@pytest.mark.slow
def test_prediction_for_magnetorquers_follows_motion_of_each_run():
    """The nonlinear filter of each run, which does not use the prediction, has the same 1-sigma."""
    design = [0.5, 0.3, -0.2, 300.0, -2.0, 0.6, 1.2, 300.0, 0.2, -1.4, 0.7, 150.0]
    plan = ManeuverPlan(dataclasses.replace(three("cubesat_1u"), duration=900.0), design)
    flights = simulate(plan.scenario, plan.design, 4, 1, end_time=plan.t_end)
    found, claimed = compute_predictions(plan, flights), flights.sigma[:, flights.find_sample()]
    np.testing.assert_allclose(found, claimed, rtol=0.1)
    assert (
        np.abs(np.log(claimed / plan.history.sigma[-1])).max() > 0.5
    )  # The nominal 1-sigma differs.


@pytest.fixture(scope="module")
def short_plan():
    scenario = dataclasses.replace(Scenario.paper(), duration=600.0)
    problem = AttitudeManeuverProblem(scenario)
    third = 150.0
    return ManeuverPlan.from_design(problem, [1.0, 0, 0, third, 0, 1.0, 0, third, 0, 0, 1.0, third])


@pytest.mark.slow
def test_valid_plan_is_achieved(short_plan):
    found = verify(short_plan, n_runs=20, seed=3)
    same = simulate(short_plan.scenario, short_plan.design, 20, 3)
    at = same.find_sample()
    rms = np.sqrt((same.errors[:, at] ** 2).mean(axis=0))
    assert found.table.loc["mag bias z", "rms"] == pytest.approx(50e3 * rms[17], rel=1e-12)
    assert found.table.loc["attitude y", "rms"] == pytest.approx(np.degrees(rms[1]), rel=1e-12)
    np.testing.assert_allclose(
        found.table["predicted"], short_plan.build_accuracy_table()["after"], rtol=1e-6
    )
    assert found.nees == pytest.approx(same.nees[:, at].mean() / 18.0)
    claimed = (same.errors[:, at] / same.sigma[:, at]) ** 2
    ratio = found.table.loc["gyro bias x", "rms / filter 1-sigma [-]"]
    assert ratio == pytest.approx(np.sqrt(claimed[:, 3].mean()))
    assert found.is_achieved  # A fifth of the default number of runs, with equally small errors.


@pytest.mark.slow
def test_underestimated_noise_is_detected(short_plan, monkeypatch):
    """The true Sun sensor has three times the declared noise and bias."""
    sun, *others = short_plan.scenario.sensors
    worse = dataclasses.replace(sun, noise_deg=6.0, initial_bias=0.06)
    truth = dataclasses.replace(short_plan.scenario, sensors=(worse, *others))
    monkeypatch.setattr(
        verification,
        "simulate",
        lambda *arguments, **keywords: simulate(*arguments, truth=truth, **keywords),
    )
    found = verify(short_plan, n_runs=20)
    assert not found.is_achieved
    assert any(state.startswith("sun bias") for state in found.states_above_prediction)
    assert any("the sun bias" in line for line in describe_failures(found))


def test_fewer_than_two_runs_raise(short_plan):
    with pytest.raises(ValueError, match="n_runs = 1: expected at least 2"):
        verify(short_plan, n_runs=1)
