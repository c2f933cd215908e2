"""Follow-up plans: a scenario and its calibration continue from an earlier calibration."""

import dataclasses
import json
from datetime import timedelta

import numpy as np
import pandas as pd
import pytest
from mgeo_attitude import AttitudeManeuverProblem, Environment, FilterModel, Scenario
from mgeo_attitude.environment.orbit import Orbit
from mgeo_attitude.geometry.rotation import rotation_matrix, rotation_vector
from mgeo_calibration import calibrate, simulate, simulate_telemetry
from mgeo_calibration.calibration.document import from_json, to_json
from mgeo_calibration.estimation.prior import PriorEstimate
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

from .runs import PLAN, check_errors, normalize_error, short

SECOND = (-0.4, 0.2, 0.5, 300.0, 0.6, 0.5, -0.3, 300.0, 0.1, -0.6, -0.4, 300.0)


@pytest.fixture(scope="module")
def first():
    """Calibration from the first maneuver and a part of the second, and its telemetry."""
    scenario = short(Scenario.cubesat_6u(), 900.0)
    telemetry = simulate_telemetry(scenario, PLAN, 4)
    return calibrate(scenario, telemetry), telemetry


def test_followup_scenario_starts_at_last_sample(first):
    found, telemetry = first
    after = found.build_followup_scenario({"maneuvers": {"count": 2}, "duration": 600.0})
    assert after.epoch == found.scenario.epoch + timedelta(seconds=900)
    assert (after.maneuvers.count, after.duration) == (2, 600.0)
    assert after.sensors == found.scenario.sensors
    model = FilterModel.from_scenario(after)
    off = Rotation.from_matrix(model.initial_attitude @ telemetry.truth.attitude[-1].T)
    assert np.degrees(off.magnitude()) < 1.0
    np.testing.assert_array_equal(model.initial_states, found.states)
    np.testing.assert_allclose(model.initial_covariance, found.covariance, rtol=1e-12, atol=1e-30)
    np.testing.assert_allclose(np.degrees(model.initial_rate), PLAN[4:7], atol=0.02)
    whole = Environment.from_scenario(short(Scenario.cubesat_6u(), 1500.0))
    rest = Environment.from_scenario(after)
    np.testing.assert_allclose(rest.position, whole.position[900:], rtol=0, atol=1e-5)
    np.testing.assert_allclose(rest.velocity, whole.velocity[900:], rtol=0, atol=1e-8)
    assert (
        np.abs(rest.field - whole.field[900:]).max() < 0.1
    )  # nT, because the field epoch differs.


@pytest.mark.parametrize("propagator", ["two-body", "j2"])
@pytest.mark.parametrize("eccentricity", [0.0, 0.001, 0.3])
def test_elements_at_later_epoch_describe_same_orbit(propagator, eccentricity):
    orbit = Orbit(
        propagator=propagator,
        semi_major_axis=1.1e7,
        eccentricity=eccentricity,
        inclination_deg=50.0,
        raan_deg=-200.0,
        argument_of_perigee_deg=300.0,
        true_anomaly_deg=170.0,
    )
    epoch, times = Scenario.paper().epoch, np.linspace(0.0, 2e4, 7)
    for time in (0.0, 777.7, 123456.0):
        later = orbit.shift_epoch(time).propagate(epoch, times)
        for one, other, least in zip(later, orbit.propagate(epoch, times + time), (1e-4, 1e-7),
                                     strict=True):  # fmt: skip
            np.testing.assert_allclose(one, other, rtol=0, atol=least)


def test_followup_scenario_from_file_equals_scenario_from_object(first):
    found, _ = first
    text = to_json(found)
    table = {"after": json.loads(text), "duration": 600.0}
    after = found.build_followup_scenario({"duration": 600.0})
    assert Scenario.from_dict(table) == after
    assert from_json(text).build_followup_scenario({"duration": 600.0}) == after
    assert AttitudeManeuverProblem.from_options(table).to_options() == after.to_dict()
    assert AttitudeManeuverProblem(after).n_var == 12


def test_prior_is_propagated_to_later_epoch(first):
    """Expected: a filter that propagates in small steps without measurements."""
    found, _ = first
    changes = {
        "epoch": "2018-06-06T00:00:00Z",
        "duration": 600.0,
        "initial": {"attitude_deg": 2.0, "pointing": "nadir"},
    }
    after = found.build_followup_scenario(changes)
    gap = (after.epoch - found.scenario.epoch).total_seconds() - found.time
    assert gap > 3600.0
    gyro, P, x = after.gyro, found.covariance[3:, 3:].copy(), found.states[3:].copy()
    steps, F = 20000, np.ones(len(x))
    h = gap / steps
    F[:3] -= gyro.bias_decay * h
    for _ in range(steps):
        x *= F
        P *= F[:, None] * F
        P[range(3), range(3)] += gyro.rate_random_walk**2 * h
    np.testing.assert_allclose(after.prior.estimates[3:], x, rtol=1e-4, atol=1e-15)
    np.testing.assert_allclose(after.prior.sigma[3:] ** 2, np.diag(P), rtol=1e-4)
    covariance = np.array(after.prior.covariance)
    np.testing.assert_allclose(covariance[3:, 3:], P, rtol=1e-4, atol=1e-18)
    np.testing.assert_allclose(covariance[:3, :3], np.radians(2.0) ** 2 * np.eye(3))
    assert not covariance[:3, 3:].any()
    # Its attitude is that of another scenario with this start on the same orbit.
    around = Environment.from_scenario(after)
    whole = Environment.from_times(found.scenario, found.time + gap + after.times)
    np.testing.assert_allclose(around.position, whole.position, rtol=0, atol=1e-3)
    free = dataclasses.replace(after, prior=None)
    expected = free.compute_initial_attitude(Environment.from_scenario(free))
    np.testing.assert_allclose(after.prior.attitude, expected, atol=1e-12)
    AttitudeManeuverProblem(after)
    from_toml = changes | {"epoch": after.epoch}
    assert found.build_followup_scenario(from_toml) == after


def test_samples_before_followup_epoch_are_ignored(first):
    """A table with both runs gives the result of the second run alone."""
    found, telemetry = first
    after = found.build_followup_scenario({"duration": 600.0})
    second = simulate_telemetry(after, SECOND, 2, initial_truth=telemetry.truth)
    np.testing.assert_allclose(second.truth.attitude[0], telemetry.truth.attitude[-1], atol=1e-12)
    np.testing.assert_array_equal(second.truth.states[0], telemetry.truth.states[-1])
    earlier = telemetry.to_frame()
    earlier["time"] -= 900.0
    both = pd.concat([earlier, second.to_frame()[1:]])
    one, other = calibrate(after, second), calibrate(after, both)
    np.testing.assert_array_equal(one.covariance, other.covariance)
    np.testing.assert_array_equal(one.states, other.states)
    with pytest.raises(ValueError, match=r"telemetry ends at 0\.000000 s after 2018-06-.*expected"):
        calibrate(after, earlier)


def test_two_successive_calibrations_equal_one_of_both_runs(first):
    """Linear models would make them equal; here the estimates differ by less than 1-sigma."""
    found, telemetry = first
    after = found.build_followup_scenario({"duration": 600.0})
    second = simulate_telemetry(after, SECOND, 2, initial_truth=telemetry.truth)
    earlier, later = telemetry.to_frame(), second.to_frame()[1:]
    later["time"] += 900.0
    whole = calibrate(short(found.scenario, 1500.0), pd.concat([earlier, later]))
    parts = calibrate(after, second)
    spread = np.sqrt(np.diag(whole.covariance))
    np.testing.assert_allclose(np.sqrt(np.diag(parts.covariance)), spread, rtol=0.01)
    scale = np.outer(spread, spread)
    np.testing.assert_allclose(parts.covariance / scale, whole.covariance / scale, atol=0.02)
    off = (parts.states - whole.states)[3:] / spread[3:]
    assert np.abs(off).max() < 0.1
    turn = Rotation.from_quat(parts.quaternion).inv() * Rotation.from_quat(whole.quaternion)
    assert np.abs(turn.as_rotvec() / spread[:3]).max() < 0.1


def test_prior_residual_agrees_with_scipy(first):
    """Residual r and Jacobian -J, by differences of scipy's rotations."""
    belief = PriorEstimate.from_scenario(first[0].build_followup_scenario())
    rng, n = np.random.default_rng(1), 18
    e = belief.sigma * rng.standard_normal(n)
    states = belief.states.copy()
    attitude = belief.attitude @ rotation_matrix(e[:3])
    for first_state in range(3, n, 3):
        block = slice(first_state, first_state + 3)
        if first_state in belief.suite.rotation_indices:
            states[block] = rotation_vector(
                rotation_matrix(states[block]) @ rotation_matrix(e[block])
            )
        else:
            states[block] += e[block]
    r, J = belief.compute_residual(attitude, states)
    P = belief.sigma[:, None] * belief.correlation * belief.sigma
    assert r @ r == pytest.approx(e @ np.linalg.solve(P, e), rel=1e-9)
    step = 1e-6 * belief.sigma
    for j in range(n):
        changed, turned = states.copy(), attitude
        block = slice(3 * (j // 3), 3 * (j // 3) + 3)
        d = np.zeros(3)
        d[j % 3] = step[j]
        if j < 3:
            turned = attitude @ rotation_matrix(d)
        elif block.start in belief.suite.rotation_indices:
            changed[block] = rotation_vector(rotation_matrix(states[block]) @ rotation_matrix(d))
        else:
            changed[block] += d
        slope = (belief.compute_residual(turned, changed)[0] - r) / step[j]
        np.testing.assert_allclose(slope, -J[:, j], rtol=1e-5, atol=1e-5 * np.abs(J[:, j]).max())


@pytest.mark.slow
def test_simulation_draws_from_prior_covariance(first):
    """Initial errors have the full covariance of the prior, and the NEES of the filter stays 1."""
    found, _ = first
    after = found.build_followup_scenario({"duration": 600.0})
    result = simulate(after, SECOND, 200, 5)
    start = result.errors[:, 0]
    P = found.covariance
    squares = np.einsum("ri,ri->r", start, np.linalg.solve(P, start.T).T)
    low, high = chi2.ppf([1e-3, 1.0 - 1e-3], 18 * 200) / (18 * 200)
    assert low < squares.mean() / 18 < high
    assert low < result.nees[:, -1].mean() / 18 < high
    ratio = result.build_table(600.0)["ratio"]
    assert ratio.between(0.8, 1.2).all()


@pytest.mark.slow
def test_second_calibration_is_consistent_and_more_accurate():
    """All parameters are more accurate, and half of them by a fifth."""
    scenario = short(Scenario.cubesat_6u(), 1200.0)
    environment, better, errors = Environment.from_scenario(scenario), [], []
    for seed in range(300, 306):
        telemetry = simulate_telemetry(scenario, PLAN, seed, environment=environment)
        after = calibrate(scenario, telemetry).build_followup_scenario({"duration": 900.0})
        second = simulate_telemetry(after, SECOND, seed + 1000, initial_truth=telemetry.truth)
        with_it = calibrate(after, second)
        without = calibrate(dataclasses.replace(after, prior=None), second)
        errors.append(normalize_error(with_it, second))
        better.append(np.sqrt(np.diag(with_it.covariance) / np.diag(without.covariance)))
    check_errors(errors, 0.998, 4.2)
    assert np.max(better) < 1.0
    assert np.median(better) < 0.8
