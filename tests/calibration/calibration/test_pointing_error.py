"""A satellite without a gyro that holds axes with a pointing error of some correlation time."""

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

from .flights import check_claimed, error
from .independent import fly_held
from .test_smoother import covariances, spread

SCENARIO = Scenario.from_dict({"preset": "cubesat_6u", "duration": 6000.0})
#: 1-sigma [deg], correlation time and step [s]: from errors that are new at every sample to errors
#: that last for the flight.
PROCESSES = (
    (2.0, 5.0, 10.0),
    (2.0, 30.0, 10.0),
    (5.0, 100.0, 10.0),
    (0.5, 300.0, 10.0),
    (5.0, 1000.0, 10.0),
    (2.0, 6000.0, 10.0),
)


def held(axes, process, seed, with_sun=True, scenario=SCENARIO, mounting=None):
    """Scenario, telemetry with truth, table and mapping of a satellite, by default mounted anyhow.

    The numbers of a process are those of `PROCESSES`.
    """
    sigma_deg, correlation_time, step = process
    mounting = mounting or Rotation.random(rng=np.random.default_rng([seed, 1]))
    if not with_sun:
        scenario = dataclasses.replace(scenario, sensors=scenario.sensors[1:])
    telemetry = fly_held(
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


def uneven(correlation_time=40.0, with_sun=True):
    """A batch of 36 samples, 10 to 600 s apart, with a gyro's bias that is constant."""
    gyro = dataclasses.replace(SCENARIO.gyro, rate_random_walk=0.0, bias_decay=0.0)
    scenario = dataclasses.replace(SCENARIO, gyro=gyro, duration=1000.0, eclipse=False)
    scenario, telemetry, table, mapping = held(
        "lvlh", (4.0, correlation_time, 10.0), 3, with_sun, scenario
    )
    table = table.drop(index=[3, 4, 9, *range(20, 79)])
    data = build_batch(scenario, read_telemetry(table, scenario, mapping))
    k = np.searchsorted(telemetry.times, data.times)
    return scenario, data, telemetry.truth.attitude[k].swapaxes(1, 2)


def test_the_linear_case_is_filterpys_smoother():
    """About the held attitude, with P = σ² at the start, φ = exp(-dt / τ) and q = σ² (1 - φ²)."""
    scenario, data, _ = uneven()
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
    both = covariances(found, spread(found, 3)) / (unit[:, :3, None] * unit[:, None, :3])
    expected = P[:, :3, :3] / (unit[:, :3, None] * unit[:, None, :3])
    np.testing.assert_allclose(both, expected, rtol=0, atol=1e-9)


def cost_by_scipy(scenario, data, p, constants):
    """Cost of errors p from the held attitude, halved Gibbs vectors by scipy's rotations."""
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


def test_the_estimate_of_large_errors_is_the_optimum():
    """A cost written once more, and the distance to its minimum along random directions."""
    scenario, data, truth = uneven()
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
def test_a_flight_gives_the_errors_of_its_sensors(axes, with_sun):
    scenario, telemetry, table, mapping = held(axes, (3.0, 300.0, 20.0), 2, with_sun)
    found = calibrate(scenario, table, mapping)
    assert found.is_consistent, found.conclusion
    e, sigma = error(found, telemetry), np.sqrt(np.diag(found.covariance))
    assert np.abs(e / sigma)[np.r_[:3, 6 : len(e)]].max() < 4.0
    rows = found.build_table().query("block == 'mag.bias'")
    assert (rows["sigma"] < 0.3 * rows["prior_sigma"]).all()


def with_axes_errors(scenario):
    """The scenario with scale factors and non-orthogonality of the magnetometer as states."""
    sun, mag = scenario.sensors
    mag = dataclasses.replace(mag, initial_scale_factor=0.05, initial_nonorthogonality_deg=1.0)
    return dataclasses.replace(scenario, sensors=(sun, mag))


def scaled_error(found, telemetry):
    """NEES per state without the gyro, of which nothing is read, and errors in 1-sigmas."""
    e = error(found, telemetry)
    seen = np.r_[:3, 6 : len(e)]
    e, P = e[seen], found.covariance[np.ix_(seen, seen)]
    return e @ np.linalg.solve(P, e) / len(e), e / np.sqrt(np.diag(P))


def test_scale_factors_do_not_explain_the_pointing_error():
    """Along the orbit's normal is little field; the sensitivity there contains the error."""
    scenario, telemetry, table, mapping = held(
        "lvlh",
        (2.0, 30.0, 10.0),
        1,
        scenario=with_axes_errors(SCENARIO),
        mounting=Rotation.identity(),
    )
    found = calibrate(scenario, table, mapping)
    assert found.is_consistent, found.conclusion
    assert np.abs(scaled_error(found, telemetry)[1]).max() < 4.0


def test_a_long_gap_leaves_the_stationary_error():
    scenario, _, table, mapping = held("inertial", (3.0, 50.0, 20.0), 2)
    found = calibrate(scenario, table.drop(index=range(100, 200)), mapping)
    assert found.is_consistent, found.conclusion


def test_a_wrong_mounting_is_refused():
    scenario, _, table, mapping = held("lvlh", (2.0, 300.0, 20.0), 2)
    wrong = dataclasses.replace(mapping.gyro, rotation="body-to-sensor")
    with pytest.raises(CalibrationError):
        calibrate(scenario, table, dataclasses.replace(mapping, gyro=wrong))


def test_a_pointing_error_needs_axes_and_a_time():
    declared = {"pointing_error_deg": 2.0, "pointing_correlation_time": 300.0}
    with pytest.raises(InvalidValue, match=r"pointing_error_deg = 2\.0: expected reference_axes"):
        GyroChannels(**declared)
    with pytest.raises(InvalidValue, match="pointing_correlation_time = None: expected a pointing"):
        GyroChannels(reference_axes="lvlh", pointing_error_deg=2.0)
    with pytest.raises(InvalidValue, match=r"pointing_error_deg = 2\.0: expected dcm or quat"):
        GyroChannels(reference_axes="inertial", **declared)


@pytest.mark.slow
@pytest.mark.parametrize(("axes", "with_sun"), [*product(("lvlh", "inertial"), (True, False))])
def test_errors_and_verdicts_of_fifty_flights_are_as_claimed(axes, with_sun):
    """Of every process; 1 % of verdicts may fail by chance."""
    supported = []
    for process in PROCESSES:
        first, claimed = crc32(repr((axes, with_sun, process)).encode()), []
        for seed in range(first, first + 50):
            scenario, telemetry, table, mapping = held(axes, process, seed, with_sun)
            found = calibrate(scenario, table, mapping)
            claimed.append(scaled_error(found, telemetry))
            supported.append(found.is_consistent)
        check_claimed(claimed, chance=0.999, worst=5.0)
    assert np.mean(supported) >= 0.97


@pytest.mark.slow
@pytest.mark.parametrize("process", [(2.0, 30.0, 10.0), (5.0, 300.0, 10.0)])
def test_axes_errors_of_a_magnetometer_are_as_claimed(process):
    scenario, claimed = with_axes_errors(SCENARIO), []
    for seed in range(24):
        flight = held("lvlh", process, seed, scenario=scenario, mounting=Rotation.identity())
        _, telemetry, table, mapping = flight
        claimed.append(scaled_error(calibrate(scenario, table, mapping), telemetry))
    check_claimed(claimed, chance=0.999, worst=5.0)
