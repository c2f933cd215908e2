"""Score tests for gyro and sensor errors that the scenario does not model."""

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

from .faults import names_cause
from .independent_simulator import TrueErrors, coning_motion, constant_rates, simulate_readings
from .runs import PLAN, normalize_error, short

PAPER, CUBESAT = (short(getattr(Scenario, name)(), 1500.0) for name in ("paper", "cubesat_6u"))
MOTIONS = {"plan": constant_rates(PLAN), "turning": coning_motion(1.0, 0.1)}
CONSTANT = {"decay": 0.0, "walk": 0.0}


def change_gyro(scenario, **gyro):
    return dataclasses.replace(scenario, gyro=dataclasses.replace(scenario.gyro, **gyro))


def simulate(scenario, seed, motion="plan", **craft):
    return simulate_readings(scenario, MOTIONS[motion], seed, TrueErrors(**craft), duration=1500.0)


def test_constant_bias_is_distinguished_from_decaying_bias():
    """Without the test, a consistent calibration was wrong by 10 sigma at 0.3 deg/s."""
    size = 0.3
    scenario = change_gyro(PAPER, initial_bias_deg_s=size)
    telemetry = simulate(scenario, 1, gyro_bias_deg_s=[size, -size, size], **CONSTANT)
    found = calibrate(scenario, telemetry)
    assert np.abs(normalize_error(found, telemetry)[1]).max() > 4.0
    assert not found.is_consistent
    assert names_cause(r"gyro\.bias decays by .*set gyro\.bias_decay", str(found.failures[0]))
    assert 'the test "unmodeled errors" failed' in found.conclusion
    row = found.build_model_test_table().loc["gyro.bias_decay"]
    assert row["is_selected"]
    assert row["p"] < 1e-6
    right = change_gyro(scenario, bias_decay=0.0)
    again = calibrate(right, telemetry)
    assert again.is_consistent, again.conclusion
    assert np.abs(normalize_error(again, telemetry)[1]).max() < 4.0


def test_underestimated_random_walk_is_identified():
    """Without the test, a consistent calibration was wrong by 15 sigma."""
    telemetry = simulate(CUBESAT, 1, walk=1.6e-6)
    found = calibrate(CUBESAT, telemetry)
    assert not found.is_consistent
    assert names_cause(r"gyro\.bias drifts by .*set gyro\.rate_random_walk", str(found.failures[0]))
    again = calibrate(change_gyro(CUBESAT, rate_random_walk=1.6e-6), telemetry)
    assert again.is_consistent, again.conclusion


@pytest.mark.parametrize(("scenario", "motion"), [(PAPER, "plan"), (CUBESAT, "turning")])
def test_correct_model_has_no_selected_error(scenario, motion):
    found = calibrate(scenario, simulate(scenario, 1, motion))
    assert found.is_consistent, found.conclusion
    assert not found.build_model_test_table()["is_selected"].any()


TURNS = [-0.1, 0.2, -0.4, 300.0, 0.3, -0.4, 0.3, 500.0, -0.2, 0.4, 0.3, 600.0,
         0.3, 0.3, -0.2, 200.0, -0.3, -0.3, 0.4, 300.0]  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("late", [0.0, 0.1])
def test_latency_of_accurate_star_tracker_has_no_false_alarm(late):
    """The gyro noise of a step is three times the tracker noise, and affects rate and attitude."""
    satellite = Scenario.microsatellite()
    tracker, *others, _ = satellite.sensors  # One of two magnetometers.
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
def test_score_estimate_equals_newton_step(walk):
    """A slightly wrong decay is estimated exactly, with its change of the last bias."""
    true = change_gyro(PAPER, initial_bias_deg_s=0.1, bias_decay=2e-5, rate_random_walk=walk)
    telemetry = simulate(true, 1, gyro_bias_deg_s=[0.1, -0.1, 0.1])
    fits = [
        fit(build_batch(each, telemetry), PriorEstimate.from_scenario(each), 1e-9).solution
        for each in (true, change_gyro(true, bias_decay=2.1e-5))
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
