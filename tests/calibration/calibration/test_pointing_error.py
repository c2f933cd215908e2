"""Satellites without a gyro whose attitude deviates from reference axes by a correlated pointing
error.
"""

import dataclasses
from itertools import product
from zlib import crc32

import numpy as np
import pytest
from filterpy.kalman import KalmanFilter
from mgeo_attitude import Scenario
from mgeo_attitude.settings.errors import InvalidValue
from mgeo_calibration import TelemetryMapping, calibrate, read_telemetry
from mgeo_calibration.calibration.diagnosis import CalibrationError
from mgeo_calibration.estimation.batch import build_batch
from mgeo_calibration.estimation.prior import PriorEstimate
from mgeo_calibration.estimation.smoother import solve, solve_linearized
from mgeo_calibration.estimation.trajectory import Partition, Trajectory
from mgeo_calibration.telemetry.mapping import GyroChannels
from scipy.spatial.transform import Rotation

from .independent_simulator import simulate_attitude_hold
from .runs import check_errors, compute_error
from .test_smoother import collect_covariances, compute_covariances

SCENARIO = Scenario.from_dict({"preset": "cubesat_6u", "duration": 6000.0})
#: 1-sigma [deg], correlation time and step [s]: from errors that are independent at every sample to
#: errors that last for the whole run.
PROCESSES = (
    (2.0, 5.0, 10.0),
    (2.0, 30.0, 10.0),
    (5.0, 100.0, 10.0),
    (0.5, 300.0, 10.0),
    (5.0, 1000.0, 10.0),
    (2.0, 6000.0, 10.0),
)


def simulate_hold(axes, process, seed, with_sun=True, scenario=SCENARIO, mounting=None):
    """Return scenario, telemetry with truth, table and mapping of a satellite with a random
    mounting by default.

    The numbers of a process are those of `PROCESSES`.
    """
    sigma_deg, correlation_time, step = process
    mounting = mounting or Rotation.random(rng=np.random.default_rng([seed, 1]))
    if not with_sun:
        scenario = dataclasses.replace(scenario, sensors=scenario.sensors[1:])
    telemetry = simulate_attitude_hold(
        scenario, axes, mounting, (np.radians(sigma_deg), correlation_time), seed, step
    )
    gyro = GyroChannels(
        reference_axes=axes,
        dcm=mounting.as_matrix().tolist(),
        rotation="sensor-to-body",
        pointing_error_deg=sigma_deg,
        pointing_correlation_time=correlation_time,
    )
    table = telemetry.to_frame().drop(columns=["gyro_x", "gyro_y", "gyro_z"])
    return scenario, telemetry, table, TelemetryMapping(gyro=gyro)


def build_uneven_batch(correlation_time=40.0, with_sun=True):
    """Return a batch of 36 samples, 10 to 600 s apart, with a constant gyro bias."""
    gyro = dataclasses.replace(SCENARIO.gyro, rate_random_walk=0.0, bias_decay=0.0)
    scenario = dataclasses.replace(SCENARIO, gyro=gyro, duration=1000.0, eclipse=False)
    scenario, telemetry, table, mapping = simulate_hold(
        "lvlh", (4.0, correlation_time, 10.0), 3, with_sun, scenario
    )
    table = table.drop(index=[3, 4, 9, *range(20, 79)])
    data = build_batch(scenario, read_telemetry(table, scenario, mapping))
    k = np.searchsorted(telemetry.times, data.times)
    return scenario, data, telemetry.truth.attitude[k].swapaxes(1, 2)


def test_linear_case_agrees_with_filterpy_smoother():
    """For small errors, P = σ² at the start, φ = exp(-dt / τ) and q = σ² (1 - φ²)."""
    scenario, data, _ = build_uneven_batch()
    suite, parts = scenario.suite, Partition.from_suite(data.suite)
    N, n = len(data.times), suite.n_states
    sigma = suite.initial_sigma(np.radians(4.0))
    kf = KalmanFilter(dim_x=n, dim_z=6)
    kf.x, kf.P = np.zeros(n), np.diag(sigma**2)
    means, Ps, Fs, Qs = [], [], [np.eye(n)], [np.zeros((n, n))]
    C = data.pointing.attitude.swapaxes(1, 2)
    for k in range(N):
        if k:
            F, Q = np.eye(n), np.zeros((n, n))
            decay = np.exp(-(data.times[k] - data.times[k - 1]) / 40.0)
            F[:3, :3], Q[:3, :3] = decay * np.eye(3), sigma[0] ** 2 * (1 - decay**2) * np.eye(3)
            Fs.append(F)
            Qs.append(Q)
            kf.predict(F=F, Q=Q)
        v = data.vectors[k, :2] @ C[k].T
        H = [suite.measurement_matrix(s, v[i], C[k]) for i, s in enumerate(suite.sensors)]
        z = [data.readings[i][k, 0] - v[i] for i in range(2)]
        R = np.diag(
            np.concatenate([np.square(s.noise_sigmas()) * np.ones(3) for s in suite.sensors])
        )
        kf.update(np.concatenate(z), R=R, H=np.vstack(H))
        means.append(kf.x.copy())
        Ps.append(kf.P.copy())
    means, P, _, _ = kf.rts_smoother(np.array(means), np.array(Ps), Fs=Fs, Qs=Qs)
    zero = np.zeros((N, n))
    at = Trajectory(data.pointing.attitude, zero)
    found = solve_linearized(data, PriorEstimate.from_scenario(scenario, data.pointing), at, parts)
    assert parts.stochastic.tolist() == [0, 1, 2]
    unit, c = np.sqrt(np.einsum("kii->ki", P)), parts.constant
    np.testing.assert_allclose(
        (found.stochastic_errors - means[:, :3]) / unit[:, :3], 0.0, atol=1e-9
    )
    np.testing.assert_allclose((found.constant_errors - means[-1, c]) / unit[-1, c], 0.0, atol=1e-9)
    both = compute_covariances(found, collect_covariances(found, 3)) / (
        unit[:, :3, None] * unit[:, None, :3]
    )
    expected = P[:, :3, :3] / (unit[:, :3, None] * unit[:, None, :3])
    np.testing.assert_allclose(both, expected, rtol=0, atol=1e-9)


def cost_by_scipy(scenario, data, p, constants):
    """Return the cost of pointing errors p and parameters, computed with scipy's rotations from
    halved Gibbs vectors.
    """
    process, sigma = data.pointing.pointing_error, scenario.suite.initial_sigma(1.0)[6:]
    decay = np.exp(-np.diff(data.times) / process.correlation_time)[:, None]
    parts = [p[0] / process.sigma, constants / sigma]
    parts.append((p[1:] - decay * p[:-1]) / (process.sigma * np.sqrt(1.0 - decay**2)))

    def turn(g):
        return Rotation.from_quat(np.concatenate([0.5 * g, np.ones((*g.shape[:-1], 1))], axis=-1))

    to_body = (Rotation.from_matrix(data.pointing.attitude) * turn(p)).inv()
    for i, sensor in enumerate(scenario.sensors):
        mu, b = constants[6 * i : 6 * i + 3], constants[6 * i + 3 : 6 * i + 6]
        seen = turn(mu).apply(to_body.apply(data.vectors[:, i])) + b
        parts.append((data.readings[i][:, 0] - seen) / sensor.noise_sigmas()[0])
    return sum((np.asarray(each) ** 2).sum() for each in parts)


def test_estimate_of_large_errors_minimizes_cost():
    """The cost is computed independently, and compared along random directions."""
    scenario, data, truth = build_uneven_batch()
    n = scenario.suite.n_states
    at = Trajectory(truth, np.zeros((len(data.times), n)))
    found = solve(data, PriorEstimate.from_scenario(scenario, data.pointing), at, 30, (1e-9, 1e-13))
    best = found.estimate
    q = Rotation.from_matrix(data.pointing.attitude.swapaxes(1, 2) @ best.attitude).as_quat()
    p, constants = 2.0 * q[:, :3] / q[:, 3:], best.states[0, 6:]
    assert np.abs(np.degrees(p)).max() > 8.0
    assert cost_by_scipy(scenario, data, p, constants) == pytest.approx(found.cost, rel=1e-9)
    unit = np.sqrt(np.diag(found.constants_covariance))[-len(constants) :]
    rng, h = np.random.default_rng(0), 0.01
    for _ in range(10):
        dp = 1e-3 * rng.standard_normal(p.shape)
        dc = unit * rng.standard_normal(len(constants))
        low, middle, high = (
            cost_by_scipy(scenario, data, p + x * dp, constants + x * dc) for x in (-h, 0.0, h)
        )
        assert abs((high - low) / (2.0 * h)) < 1e-5 * (high - 2.0 * middle + low) / h**2


@pytest.mark.parametrize(("axes", "with_sun"), [("lvlh", True), ("inertial", False)])
def test_sensor_errors_are_estimated_without_gyro(axes, with_sun):
    scenario, telemetry, table, mapping = simulate_hold(axes, (3.0, 300.0, 20.0), 2, with_sun)
    found = calibrate(scenario, table, mapping)
    assert found.is_consistent, found.conclusion
    e, sigma = compute_error(found, telemetry), np.sqrt(np.diag(found.covariance))
    assert np.abs(e / sigma)[np.r_[:3, 6 : len(e)]].max() < 4.0
    rows = found.build_table().query("block == 'mag.bias'")
    assert (rows["sigma"] < 0.3 * rows["prior_sigma"]).all()


def add_axes_errors(scenario):
    """Return a scenario with scale factors and non-orthogonality of the magnetometer as states."""
    sun, mag = scenario.sensors
    mag = dataclasses.replace(mag, initial_scale_factor=0.05, initial_nonorthogonality_deg=1.0)
    return dataclasses.replace(scenario, sensors=(sun, mag))


def normalize_sensor_error(found, telemetry):
    """Return the NEES per state without the gyro, which has no readings, and the errors in
    1-sigmas.
    """
    e = compute_error(found, telemetry)
    seen = np.r_[:3, 6 : len(e)]
    e, P = e[seen], found.covariance[np.ix_(seen, seen)]
    return e @ np.linalg.solve(P, e) / len(e), e / np.sqrt(np.diag(P))


def test_scale_factors_do_not_absorb_pointing_error():
    """Along the orbit normal the field is weak, so that the sensitivity is correlated with the
    error.
    """
    scenario, telemetry, table, mapping = simulate_hold(
        "lvlh",
        (2.0, 30.0, 10.0),
        1,
        scenario=add_axes_errors(SCENARIO),
        mounting=Rotation.identity(),
    )
    found = calibrate(scenario, table, mapping)
    assert found.is_consistent, found.conclusion
    assert np.abs(normalize_sensor_error(found, telemetry)[1]).max() < 4.0


def test_stationary_variance_returns_after_long_gap():
    scenario, _, table, mapping = simulate_hold("inertial", (3.0, 50.0, 20.0), 2)
    found = calibrate(scenario, table.drop(index=range(100, 200)), mapping)
    assert found.is_consistent, found.conclusion


def test_wrong_mounting_raises():
    scenario, _, table, mapping = simulate_hold("lvlh", (2.0, 300.0, 20.0), 2)
    wrong = dataclasses.replace(mapping.gyro, rotation="body-to-sensor")
    with pytest.raises(CalibrationError):
        calibrate(scenario, table, dataclasses.replace(mapping, gyro=wrong))


def test_pointing_error_requires_axes_and_correlation_time():
    declared = {"pointing_error_deg": 2.0, "pointing_correlation_time": 300.0}
    with pytest.raises(InvalidValue, match=r"pointing_error_deg = 2\.0: expected reference_axes"):
        GyroChannels(**declared)
    with pytest.raises(InvalidValue, match="pointing_correlation_time = None: expected a pointing"):
        GyroChannels(reference_axes="lvlh", pointing_error_deg=2.0)
    with pytest.raises(InvalidValue, match=r"pointing_error_deg = 2\.0: expected dcm or quat"):
        GyroChannels(reference_axes="inertial", **declared)


@pytest.mark.slow
@pytest.mark.parametrize(("axes", "with_sun"), [*product(("lvlh", "inertial"), (True, False))])
def test_errors_and_conclusions_of_fifty_runs_agree_with_covariance(axes, with_sun):
    """For every pointing process; 1 % of the conclusions may be false alarms."""
    supported = []
    for process in PROCESSES:
        first, claimed = crc32(repr((axes, with_sun, process)).encode()), []
        for seed in range(first, first + 50):
            scenario, telemetry, table, mapping = simulate_hold(axes, process, seed, with_sun)
            found = calibrate(scenario, table, mapping)
            claimed.append(normalize_sensor_error(found, telemetry))
            supported.append(found.is_consistent)
        check_errors(claimed, chance=0.999, worst=5.0)
    assert np.mean(supported) >= 0.97


@pytest.mark.slow
@pytest.mark.parametrize("process", [(2.0, 30.0, 10.0), (5.0, 300.0, 10.0)])
def test_magnetometer_axes_errors_are_estimated_within_sigma(process):
    scenario, claimed = add_axes_errors(SCENARIO), []
    for seed in range(24):
        flight = simulate_hold(
            "lvlh", process, seed, scenario=scenario, mounting=Rotation.identity()
        )
        _, telemetry, table, mapping = flight
        claimed.append(normalize_sensor_error(calibrate(scenario, table, mapping), telemetry))
    check_errors(claimed, chance=0.999, worst=5.0)
