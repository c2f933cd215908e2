"""True motion and readings of simulated runs, against scipy and closed forms."""

import dataclasses
from itertools import pairwise

import numpy as np
import pytest
from mgeo_attitude import (
    Environment,
    EnvironmentErrors,
    FilterModel,
    Magnetometer,
    Scenario,
    SunSensor,
)
from mgeo_attitude.environment.sun_moon import sun_position, visible_sun_fraction
from mgeo_attitude.environment.times import compute_julian_dates
from mgeo_attitude.scenario import Convergence, InitialConditions, ManeuverBounds
from mgeo_calibration import calibrate
from mgeo_calibration.simulators.kinematic import simulate_telemetry
from mgeo_calibration.simulators.simulated_run import discretize_at_rest, draw_errors
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

from ...attitude.geometry.test_rotation import as_scipy
from .runs import build_zero_errors, run_filter, simulate_motion

PLAN = np.array([0.5, -0.3, 0.8, 80.3, -0.7, 0.9, 0.1, 60.0, 0.2, 0.4, -0.9, 500.0])
DURATION = 200


def short(scenario, **changes):
    return dataclasses.replace(
        scenario,
        duration=float(DURATION),
        convergence=Convergence(window=float(DURATION)),
        **changes,
    )


@pytest.fixture(scope="module")
def model():
    return FilterModel.from_scenario(short(Scenario.paper()))


def interpolate_body_rates(t):
    """Return the rate of the plan at a time. By hand: the second maneuver starts at the first step
    after 80.3 s, the third at the first step after 140.3 s.
    """
    return np.radians(PLAN[0:3] if t < 81 else PLAN[4:7] if t < 141 else PLAN[8:11])


def integrate_attitude(rates, start, t):
    """Return the attitude C at a time by numerical integration of C' = -[ω×] C."""

    def derivative(at, flat):
        x, y, z = rates(at)
        return (-np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]) @ flat.reshape(3, 3)).ravel()

    C, legs = start.ravel(), [0, 81, 141, t]
    for begin, end in pairwise(legs):
        inside = (begin + 1e-9, end - 1e-9)  # The rates jump at the ends.
        C = solve_ivp(derivative, inside, C, method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
    return C.reshape(3, 3)


def test_true_and_propagated_attitudes_agree_with_integration(model):
    """The sensors are blind, so that the estimate is the gyro attitude with a constant bias."""
    suite = dataclasses.replace(
        model.suite, gyro=dataclasses.replace(model.suite.gyro, bias_decay=0.0)
    )
    blind = dataclasses.replace(model, suite=suite, available=np.zeros_like(model.available))
    theta, bias = np.array([0.3, -0.2, 0.1]), np.array([2e-3, -1e-3, 3e-3])
    draws = build_zero_errors(blind, DURATION)
    draws.initial_errors[:3], draws.initial_errors[3:6] = theta, bias
    record = run_filter(blind, PLAN, np.array([0, DURATION]), draws)

    np.testing.assert_allclose(record.errors[0, 0, :6], [*theta, *bias], rtol=1e-14)
    truth = integrate_attitude(interpolate_body_rates, as_scipy(-theta).as_matrix(), DURATION)
    estimate = integrate_attitude(lambda t: interpolate_body_rates(t) + bias, np.eye(3), DURATION)
    quaternion = Rotation.from_matrix(estimate @ truth.T).as_quat()
    expected = 2.0 * quaternion[:3] / quaternion[3]
    np.testing.assert_allclose(record.errors[0, 1, :3], expected, rtol=0, atol=1e-9)
    np.testing.assert_allclose(record.errors[0, 1, 3:6], bias, rtol=1e-13)
    assert not record.n_innovations.any()


def test_gyro_noise_has_covariance_of_equation_2():
    """An independent quadrature gives the joint covariance of the bias and its integral over a
    step.
    """
    gyro = dataclasses.replace(
        Scenario.paper().gyro, bias_decay=0.3, rate_random_walk=0.02, initial_bias_deg_s=1.0
    )
    model = FilterModel.from_scenario(short(Scenario.paper(), gyro=gyro, step=0.5))
    F, Q = discretize_at_rest(model)
    A = np.array([[0.0, -1.0], [0.0, -0.3]])
    D = np.diag([(np.radians(gyro.angle_random_walk_deg_per_sqrt_h) / 60.0) ** 2, 0.02**2])
    nodes, weights = np.polynomial.legendre.leggauss(20)
    expected = sum(
        0.25 * w * expm(A * s) @ D @ expm(A * s).T
        for s, w in zip(0.25 * (nodes + 1.0), weights, strict=True)
    )
    for axis in range(3):
        pair = [axis, 3 + axis]
        np.testing.assert_allclose(F[np.ix_(pair, pair)], expm(A * 0.5), rtol=1e-12)
        np.testing.assert_allclose(Q[np.ix_(pair, pair)], expected, rtol=1e-12)

    drawn = draw_errors(model, 40_000, np.random.default_rng(3)).process_noise
    sample = drawn.T @ drawn / len(drawn)
    scale = np.sqrt(np.outer(np.diag(Q), np.diag(Q)))
    # The standard deviation of an entry is at most sqrt(2 / 40000) of its scale: 0.7 %.
    assert np.abs((sample - Q) / scale).max() < 4.5 * np.sqrt(2.0 / 40_000)


@pytest.mark.slow
def test_varying_sensor_errors_are_ornstein_uhlenbeck_processes():
    """They are stationary and independent, with the autocovariance σ² exp(-t / τ)."""
    world = EnvironmentErrors(albedo=0.05, albedo_correlation_time=15.0, field_error_nt=80)
    model = FilterModel.from_scenario(short(Scenario.paper(), environment_errors=world, step=2.0))
    F, Q = discretize_at_rest(model)
    expected = np.repeat([np.exp(-2.0 / 15.0), np.exp(-2.0 / 300.0)], 3)
    np.testing.assert_allclose(np.diag(F)[6:], expected, rtol=1e-13)
    variances = np.repeat([0.05**2, (80.0 / 50_000.0) ** 2], 3)
    np.testing.assert_allclose(np.diag(Q)[6:], variances * (1.0 - expected**2), rtol=1e-12)

    n, runs = DURATION // 2, 600
    flights = [
        simulate_motion(model, PLAN, draw_errors(model, n, generator)).varying_states[:, 3:6]
        for generator in np.random.default_rng(6).spawn(runs)
    ]
    samples = np.moveaxis(np.array(flights), 1, 0).reshape(n + 1, -1)  # 1800 processes.
    covariance = samples @ samples.T / samples.shape[1]
    lag = 2.0 * np.abs(np.subtract.outer(np.arange(n + 1), np.arange(n + 1)))
    # The standard deviation of an entry is at most sqrt(2 / 1800) of the variance: 3.3 %.
    error = covariance / 0.05**2 - np.exp(-lag / 15.0)
    assert np.abs(error).max() < 5.0 * np.sqrt(2.0 / samples.shape[1])


def test_orbit_error_moves_eclipse_and_calibration_stays_consistent():
    """The Sun sensor also reports in the predicted eclipse."""
    world = EnvironmentErrors(orbit_error_m=(40_000.0, 1000.0, 1000.0))
    scenario = dataclasses.replace(
        Scenario.cubesat_6u(),
        duration=600.0,
        environment_errors=world,
        maneuvers=ManeuverBounds(count=3),
    )
    scenario = scenario.shift_start(3700.0)  # The Sun sets after 231 s.
    sent = simulate_telemetry(scenario, [*PLAN[:11], 400.0], seed=6)
    error = 1e3 * sent.truth.states[:, 6:9]
    at, environment = scenario.times, Environment.from_scenario(scenario)
    r, v = environment.position, environment.velocity
    axes = [np.cross(np.cross(r, v), r), np.cross(r, v), r]
    there = r + sum(
        e[:, None] * axis / np.linalg.norm(axis, axis=1)[:, None]
        for e, axis in zip(error.T, axes, strict=True)
    )
    dark = visible_sun_fraction(there, sun_position(compute_julian_dates(scenario.epoch, at))) < 0.5
    believed = ~environment.sunlit
    assert 3 <= np.sum(dark & ~believed) <= 30
    assert not np.any(believed & ~dark)
    np.testing.assert_array_equal(np.isnan(sent.sensors["sun"][1:, 0]), dark[1:])

    noise = np.random.default_rng(1).normal(0.0, np.radians(0.5), (dark.sum(), 3))
    sent.sensors["sun"][dark] = noise
    made = calibrate(scenario, sent)
    assert made.is_consistent
    assert not made.outliers


def test_sensors_measure_only_if_available():
    narrow = SunSensor(boresight=(1.0, 0.0, 0.0), half_angle_deg=60.0)
    of = short(Scenario.paper(), sensors=(narrow, Magnetometer()))
    seen = FilterModel.from_scenario(of)
    available = seen.available.copy()
    available[50:80, 0] = False
    seen = dataclasses.replace(seen, available=available)
    draws = build_zero_errors(seen, DURATION)
    draws.initial_errors[:3] = theta = np.array([0.5, 0.8, -0.3])
    record = run_filter(seen, PLAN, np.arange(DURATION + 1), draws)
    expected = []
    for k in range(1, DURATION + 1):
        legs = [(PLAN[0:3], min(k, 81)), (PLAN[4:7], min(k, 141) - 81), (PLAN[8:11], k - 141)]
        C = as_scipy(-theta)
        for rate, seconds in legs:
            C = Rotation.from_rotvec(-np.radians(rate) * max(seconds, 0)) * C
        inside = C.apply(seen.references[k, 0])[0] >= np.cos(np.radians(60.0))
        expected.append(inside and available[k, 0])
    assert 0 < sum(expected) < 170
    np.testing.assert_array_equal(record.n_innovations[0, 1:, 0], expected)
    np.testing.assert_array_equal(record.n_innovations[0, 1:, 1], 1)


@pytest.mark.parametrize("pointing", ["inertial", "nadir"])
def test_readings_agree_with_scipy_rotations(pointing):
    """All sensors of two runs with errors and noise."""
    initial = InitialConditions(pointing=pointing)
    model = FilterModel.from_scenario(short(Scenario.paper(), initial=initial))
    begun = model.initial_attitude
    assert (begun == np.eye(3)).all() == (pointing == "inertial")
    plan = [integrate_attitude(interpolate_body_rates, np.eye(3), t) for t in (1, 100, DURATION)]
    for generator in np.random.default_rng(5).spawn(2):
        draws = draw_errors(model, DURATION, generator)
        flight, x = simulate_motion(model, PLAN, draws), draws.initial_errors
        for k, planned in zip((1, 100, DURATION), plan, strict=True):
            C = planned @ as_scipy(-x[:3]).as_matrix() @ begun
            found = flight.motion.attitude[k] @ flight.initial_rotation
            np.testing.assert_allclose(found, C, rtol=0, atol=1e-9)
            for index, first in ((0, 6), (1, 12)):
                seen = as_scipy(x[first : first + 3]).apply(C @ model.references[k, index])
                seen += x[first + 3 : first + 6] + draws.measurement_noise[k, index]
                found = flight.readings.sensors[index][k, 0]
                np.testing.assert_allclose(found, seen, rtol=0, atol=1e-9)
        assert np.isnan(flight.readings.sensors[0][0]).all()  # There is no reading at the start.
