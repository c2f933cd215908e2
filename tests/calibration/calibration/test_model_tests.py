"""What gyro and sensors do beside what the scenario says of them."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import EnvironmentErrors, Scenario
from mgeo_calibration import calibrate
from mgeo_calibration import simulate_telemetry as fly_own
from mgeo_calibration.estimation.batch import build_batch
from mgeo_calibration.estimation.fit import fit
from mgeo_calibration.estimation.model_errors import build_bias_decay_error, build_bias_drift_error
from mgeo_calibration.estimation.prior import PriorEstimate
from mgeo_calibration.estimation.score import compute_scores

from .faults import says
from .flights import PLAN, normalized, short
from .independent import Craft, coning, fly, steady

PAPER, CUBESAT = (short(getattr(Scenario, name)(), 1500.0) for name in ("paper", "cubesat_6u"))
MOTIONS = {"plan": steady(PLAN), "turning": coning(1.0, 0.1)}
CONSTANT = {"decay": 0.0, "walk": 0.0}


def believed(scenario, **gyro):
    return dataclasses.replace(scenario, gyro=dataclasses.replace(scenario.gyro, **gyro))


def flown(scenario, seed, motion="plan", **craft):
    return fly(scenario, MOTIONS[motion], seed, Craft(**craft), duration=1500.0)


def test_a_bias_that_is_constant_is_told_from_one_that_decays():
    """It ended 10 sigma wrong at 0.3 deg/s, supported."""
    size = 0.3
    scenario = believed(PAPER, initial_bias_deg_s=size)
    telemetry = flown(scenario, 1, gyro_bias_deg_s=[size, -size, size], **CONSTANT)
    found = calibrate(scenario, telemetry)
    assert np.abs(normalized(found, telemetry)[1]).max() > 4.0
    assert not found.is_consistent
    assert says(r"gyro\.bias decays by .*: gyro\.bias_decay", found.failures[0])
    assert found.conclusion.startswith("the model ")
    row = found.build_model_test_table().loc["gyro.bias_decay"]
    assert row["is_selected"]
    assert row["p"] < 1e-6
    right = believed(scenario, bias_decay=0.0)
    again = calibrate(right, telemetry)
    assert again.is_consistent, again.conclusion
    assert np.abs(normalized(again, telemetry)[1]).max() < 4.0


def test_a_bias_that_walks_by_more_than_is_said_is_told():
    """It ended 15 sigma wrong, supported."""
    telemetry = flown(CUBESAT, 1, walk=1.6e-6)
    found = calibrate(CUBESAT, telemetry)
    assert not found.is_consistent
    assert says(r"gyro\.bias drifts by .*: gyro\.rate_random_walk", found.failures[0])
    again = calibrate(believed(CUBESAT, rate_random_walk=1.6e-6), telemetry)
    assert again.is_consistent, again.conclusion


@pytest.mark.parametrize(("scenario", "motion"), [(PAPER, "plan"), (CUBESAT, "turning")])
def test_nothing_is_named_of_what_is_as_it_is_said(scenario, motion):
    found = calibrate(scenario, flown(scenario, 1, motion))
    assert found.is_consistent, found.conclusion
    assert not found.build_model_test_table()["is_selected"].any()


TURNS = [-0.1, 0.2, -0.4, 300.0, 0.3, -0.4, 0.3, 500.0, -0.2, 0.4, 0.3, 600.0,
         0.3, 0.3, -0.2, 200.0, -0.3, -0.3, 0.4, 300.0]  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("late", [0.0, 0.1])
def test_a_tracker_that_is_better_than_the_gyro_is_late_only_where_it_is(late):
    """The gyro's noise of a step is three times its own, and is in the rate and in the attitude."""
    satellite = Scenario.microsatellite()
    tracker, *others, _ = satellite.sensors  # of two magnetometers one
    scenario = short(satellite, 2400.0, environment_errors=EnvironmentErrors())
    sees = {"sun_exclusion_deg": None, "earth_exclusion_deg": None}
    tracker = dataclasses.replace(tracker, initial_latency_s=late, **sees)
    true = dataclasses.replace(scenario, sensors=(tracker, *others))
    scenario = dataclasses.replace(
        true, sensors=(dataclasses.replace(tracker, initial_latency_s=0.0), *others)
    )
    telemetry = fly_own(true, TURNS, seed=4)
    found = calibrate(scenario, telemetry)
    if not late:
        assert found.is_consistent, found.conclusion
        assert not found.build_model_test_table()["is_selected"].any()
    else:
        assert "str_a.latency" in found.build_model_test_table().query("is_selected").index
        again = calibrate(true, telemetry)
        assert again.is_consistent, again.conclusion
        first = 3 * again.suite.blocks.index("str_a.latency")
        error = again.states[first : first + 3] - telemetry.truth.states[-1, first : first + 3]
        assert (np.abs(error) < 3.0 * np.sqrt(np.diag(again.covariance)[first : first + 3])).all()


@pytest.mark.parametrize("walk", [3e-8, 0.0])
def test_a_score_is_the_step_of_an_estimate(walk):
    """A decay that is a little wrong is found as it is, with its change of the last bias."""
    true = believed(PAPER, initial_bias_deg_s=0.1, bias_decay=2e-5, rate_random_walk=walk)
    telemetry = flown(true, 1, gyro_bias_deg_s=[0.1, -0.1, 0.1])
    fits = [
        fit(build_batch(each, telemetry), PriorEstimate.from_scenario(each), 1e-9).solution
        for each in (true, believed(true, bias_decay=2.1e-5))
    ]
    found = [
        compute_scores(
            each, {"decay": build_bias_decay_error(each), "drift": build_bias_drift_error(each)}
        )
        for each in fits
    ]
    moved = [each.compute_score("decay").estimate[0] / 1499.0 for each in found]
    assert moved[0] - moved[1] == pytest.approx(1e-6, rel=0.05)
    ends = [each.estimate.states[-1, 3:6] for each in fits]
    change = found[0].state_changes[3:6, 0] * 1e-6 * 1499.0
    np.testing.assert_allclose(ends[1] - ends[0], change, rtol=0.05)
