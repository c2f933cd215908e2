"""The smoother against dense least squares, filterpy's smoother and scipy's optimizer."""

import dataclasses
from itertools import pairwise

import numpy as np
import pytest
from filterpy.kalman import KalmanFilter
from mgeo_attitude import FilterModel, Scenario, SunSensor, TwoAxisSunSensor
from mgeo_attitude.filter.reference import discretize_van_loan
from mgeo_attitude.geometry.rotation import rotation_matrix
from mgeo_attitude.maneuvers.motion import compute_attitudes
from mgeo_calibration.estimation.batch import Batch, build_batch
from mgeo_calibration.estimation.kinematics import linearize_process
from mgeo_calibration.estimation.linearization import linearize_sensor
from mgeo_calibration.estimation.prior import PriorEstimate
from mgeo_calibration.estimation.residuals import compute_filter_estimates, compute_residuals
from mgeo_calibration.estimation.smoother import (
    SmoothedCovariance,
    compute_last_covariance,
    smooth_covariances,
    solve,
    solve_linearized,
)
from mgeo_calibration.estimation.trajectory import Partition, Trajectory
from scipy.linalg import qr
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from ...attitude.filter.suites import CHANNELS, FAST, SUITES
from .runs import short, simulate_from_any_attitude

STEPS = 40
PLAN = (0.5, 0.3, -0.2, 15.0, -0.3, 0.6, 0.2, 15.0, 0.2, -0.4, 0.7, 600.0)


#: Gyro with a noise comparable to that of the sensors.
MEMS = {"angle_random_walk_deg_per_sqrt_h": 1.0, "rate_random_walk": 1e-5}


def build_scenario(name, **gyro):
    suite = SUITES[name]
    gyro = dataclasses.replace(suite.gyro, **gyro)
    return short(
        dataclasses.replace(
            Scenario.paper(),
            gyro=gyro,
            sensors=suite.sensors,
            environment_errors=suite.environment_errors,
        ),
        float(STEPS),
        housekeeping_channels=CHANNELS,
    )


def build_batch_near_truth(of, seed=1, broken=True):
    """Return a batch with irregular steps and an optional break, and a trajectory near the
    truth.
    """
    telemetry = simulate_from_any_attitude(of, seed, plan=PLAN)
    data = build_batch(of, telemetry)
    keep = np.delete(np.arange(len(data.times)), [5, 6, 17, 30])
    rates = np.stack([data.gyro_rates[a:b].mean(axis=0) for a, b in pairwise(keep)])
    breaks = np.zeros(len(keep) - 1, dtype=bool)
    breaks[20] = broken
    data = dataclasses.replace(
        data,
        times=data.times[keep],
        gyro_rates=rates,
        rate_changes=np.zeros_like(rates),
        excess_angle_variance=np.linspace(0.0, 1e-10, len(breaks))[:, None] * [1.0, 1.0, 1.0],
        breaks=breaks,
        channel_values=data.channel_values[keep],
        readings=tuple(rows[keep] for rows in data.readings),
        vectors=data.vectors[keep],
    )
    k = np.searchsorted(telemetry.times, data.times)
    truth, driven = telemetry.truth, Partition.from_suite(data.suite).stochastic
    states = 0.9 * truth.states[k]
    for state in np.setdiff1d(np.arange(states.shape[1]), driven):
        states[:, state] = states[0, state]
        if 3 <= state < 6:
            states[:, state] *= np.exp(-data.suite.gyro.bias_decay * (data.times - data.times[0]))
    turn = rotation_matrix(np.array([0.01, -0.02, 0.015]))
    return data, Trajectory(truth.attitude[k].swapaxes(1, 2) @ turn, states)


def collect_covariances(solution, n=None):
    """Return the smoothed covariances of all samples, concatenated over the spans."""
    spans = [
        (found.conditional_covariance[span.first_new :], found.derivative[span.first_new :])
        for span, found in smooth_covariances(solution, n)
    ]
    return SmoothedCovariance(*map(np.concatenate, zip(*reversed(spans), strict=True)))


def compute_covariances(solution, found):
    """Return the covariances of the n leading stochastic states at every sample, shape (N, n,
    n).
    """
    return (
        found.conditional_covariance
        + found.derivative @ solution.covariance @ found.derivative.swapaxes(1, 2)
    )


def build_dense_equations(data, sigma, at, parts):
    """Return Jacobian J and residual r of all residuals in 1-sigmas, for e_0, e_1, ... and e_c."""
    N, d, c = len(data.times), len(parts.stochastic), len(parts.constant)
    move, rows, right = linearize_process(data, at, parts), [], []

    def row(m):
        rows.append(np.zeros((m, N * d + c)))
        return rows[-1]

    r, J = PriorEstimate.from_suite(data.suite).compute_residual(at.attitude[0], at.states[0])
    now = row(len(r))
    now[:, :d], now[:, N * d :] = J[:, parts.stochastic], J[:, parts.constant]
    right.append(r)
    for k in range(N - 1):
        root = np.linalg.inv(np.linalg.cholesky(move.Q[k]))
        now = row(d)
        now[:, k * d : k * d + d], now[:, k * d + d : k * d + 2 * d] = -root @ move.F[k], root
        now[:, N * d :] = -root[:, :3] @ move.G[k]
        right.append(root @ move.defect[k])
    for index in range(len(data.readings)):
        seen = linearize_sensor(data, index, at)
        for k, z, H in zip(seen.samples, seen.z, seen.H, strict=True):
            now = row(len(z))
            for column, state in zip(H.T, seen.states, strict=True):
                if state in parts.stochastic:
                    now[:, k * d + np.flatnonzero(parts.stochastic == state)[0]] = (
                        column / seen.noise
                    )
                else:
                    j = np.flatnonzero(parts.constant == state)[0]
                    now[:, N * d + j] = column / seen.noise * move.constant_factors[k, j]
            right.append(z / seen.noise)
    return np.vstack(rows), np.concatenate(right)


@pytest.mark.parametrize(
    ("name", "gyro", "broken"),
    [
        *((name, MEMS, True) for name in FAST),
        *(pytest.param(n, MEMS, True, marks=pytest.mark.slow) for n in SUITES if n not in FAST),
        *((name, {}, False) for name in FAST),
        *((name, {}, True) for name in FAST),
        ("paper", MEMS | {"rate_random_walk": 0.0}, True),
        ("full gyro", MEMS | {"rate_random_walk": 0.0, "bias_decay": 1e-3}, True),
        ("paper", {"angle_random_walk_deg_per_sqrt_h": 1e-3, "rate_random_walk": 1e-9}, False),
    ],
)
def test_steps_and_covariances_agree_with_dense_least_squares(name, gyro, broken):
    data, at = build_batch_near_truth(build_scenario(name, **gyro), broken=broken)
    sigma, parts = data.suite.initial_sigma(1.0), Partition.from_suite(data.suite)
    found = solve_linearized(data, PriorEstimate.from_suite(data.suite), at, parts)
    J, r = build_dense_equations(data, sigma, at, parts)
    N, d = found.stochastic_errors.shape
    scale = np.concatenate([np.tile(sigma[parts.stochastic], N), sigma[parts.constant]])
    # Rows with the largest weights first, for accuracy with weights of 1 and 1e7.
    order = np.argsort(-np.abs(J * scale).max(axis=1))
    Q, R, pivots = qr((J * scale)[order], mode="economic", pivoting=True)
    inverse = np.empty_like(R)
    inverse[pivots] = np.linalg.inv(R)
    e = scale * (inverse @ (Q.T @ r[order]))
    P = inverse @ inverse.T * scale * scale[:, None]
    unit = np.sqrt(np.diag(P))
    assert found.cost == pytest.approx(r @ r, rel=1e-12)
    np.testing.assert_allclose(
        (found.stochastic_errors.ravel() - e[: N * d]) / unit[: N * d], 0.0, atol=1e-10
    )
    np.testing.assert_allclose(
        (found.constant_errors - e[N * d :]) / unit[N * d :], 0.0, atol=1e-10
    )
    both = np.outer(unit, unit)
    P = P / both
    own = found.constants_covariance / both[N * d :, N * d :]
    np.testing.assert_allclose(own, P[N * d :, N * d :], rtol=0, atol=1e-10)
    blocks, leading = (
        compute_covariances(found, collect_covariances(found, d)),
        collect_covariances(found),
    )
    measured = [linearize_sensor(data, index, at).states for index in range(len(data.readings))]
    n = int(np.flatnonzero(np.isin(parts.stochastic, np.concatenate(measured)))[-1]) + 1
    np.testing.assert_allclose(compute_covariances(found, leading), blocks[:, :n, :n], rtol=1e-9)
    for k in range(N):
        block = slice(k * d, k * d + d)
        np.testing.assert_allclose(
            blocks[k] / both[block, block], P[block, block], rtol=0, atol=1e-10
        )
    last = compute_last_covariance(found)
    index = np.empty(len(sigma), dtype=int)
    index[parts.stochastic] = (N - 1) * d + np.arange(d)
    index[parts.constant] = N * d + np.arange(len(parts.constant))
    grown = np.ones(len(sigma))
    grown[parts.constant] = found.constant_factors[-1]
    expected = P[np.ix_(index, index)] * np.outer(grown, grown)
    np.testing.assert_allclose(last / both[np.ix_(index, index)], expected, rtol=0, atol=1e-10)


def test_residual_against_other_readings_agrees_with_solution_without_reading():
    data, at = build_batch_near_truth(build_scenario("paper"))
    sigma, parts = data.suite.initial_sigma(1.0), Partition.from_suite(data.suite)
    settled = solve(data, PriorEstimate.from_suite(data.suite), at, 30)
    within = compute_residuals(settled).normalized_squares
    for index, k in ((0, 3), (1, 12), (0, 30)):
        without = np.zeros(within.shape, dtype=bool)
        without[index, k] = True
        believed = PriorEstimate.from_suite(data.suite)
        other = solve_linearized(data, believed, settled.trajectory, parts, without)
        seen = linearize_sensor(data, index, settled.trajectory)
        row = int(np.flatnonzero(seen.samples == k)[0])
        H = np.zeros((3, len(sigma)))
        H[:, seen.states] = seen.H[row]
        own, fixed = H[:, parts.stochastic], H[:, parts.constant] * other.constant_factors[k]
        known = collect_covariances(other, len(parts.stochastic))
        J = own @ known.derivative[k]
        J[:, len(parts.stochastic) :] += fixed
        S = (
            np.diag(seen.noise**2)
            + own @ known.conditional_covariance[k] @ own.T
            + J @ other.covariance @ J.T
        )
        r = seen.z[row] - own @ other.stochastic_errors[k] - fixed @ other.constant_errors
        assert within[index, k] == pytest.approx(r @ np.linalg.solve(S, r), rel=1e-5)
        left = compute_residuals(other)
        np.testing.assert_allclose(left.values[index, k], r, rtol=1e-12)
        assert left.normalized_squares[index, k] == pytest.approx(
            r @ np.linalg.solve(S, r), rel=1e-9
        )


def linear_case(name):
    """Return a batch at the planned attitude with the rates of the plan, so that all defects are
    zero.
    """
    of = build_scenario(name, **MEMS)
    model = FilterModel.from_scenario(of)
    plan = model.build_schedule(np.atleast_2d(PLAN))
    rates, starts = plan.rates[0], plan.starts[0]
    C = compute_attitudes(rates, starts, STEPS, 1.0)
    stretch = np.searchsorted(starts, np.arange(STEPS), side="right") - 1
    rng = np.random.default_rng(4)
    sensors = []
    for index, sensor in enumerate(model.suite.sensors):
        rows = np.einsum("kij,kj->ki", C, model.references[:, index])
        rows = rows + np.array(sensor.noise_sigmas()) * rng.standard_normal(rows.shape)
        rows[rng.random(STEPS + 1) < 0.3] = np.nan
        sensors.append(rows[:, None])
    data = Batch(
        suite=model.suite,
        times=model.times,
        gyro_rates=rates[stretch],
        rate_changes=np.zeros((STEPS, 3)),
        excess_angle_variance=np.zeros((STEPS, 3)),
        breaks=np.zeros(STEPS, dtype=bool),
        readings=tuple(sensors),
        noise=np.array([sensor.noise_sigmas() for sensor in model.suite.sensors]),
        vectors=model.references,
        channel_values=model.sensitivity_factors,
    )
    zero = np.zeros((STEPS + 1, model.suite.n_states))
    return model, data, rates[stretch], C, Trajectory(C.swapaxes(1, 2), zero)


@pytest.mark.parametrize("name", ["paper", "varying errors", "orbit error", "cubesat_6u_full"])
def test_linear_case_agrees_with_filterpy_smoother(name):
    model, data, rates, C, at = linear_case(name)
    suite, n = model.suite, model.suite.n_states
    sigma, parts = suite.initial_sigma(1.0), Partition.from_suite(suite)
    kf = KalmanFilter(dim_x=n, dim_z=6)
    kf.x, kf.P = np.zeros(n), np.diag(sigma**2)
    means, Ps, Fs, Qs = [], [], [], []
    for k in range(STEPS + 1):
        if k:
            F, Q = discretize_van_loan(model, rates[k - 1])
            Fs.append(F)
            Qs.append(Q)
            kf.predict(F=F, Q=Q)
        H, R, z = [], [], []
        for index, sensor in enumerate(suite.sensors):
            y = data.readings[index][k, 0]
            if np.isfinite(y).all():
                v = C[k] @ model.references[k, index]
                auxiliary_vectors = model.references[k, suite.find_auxiliary_rows(index)] @ C[k].T
                H.append(suite.measurement_matrix(sensor, v, C[k], auxiliary_vectors))
                R.extend(np.square(sensor.noise_sigmas()))
                z.extend(y - v)
        if H:
            kf.update(np.array(z), R=np.diag(R), H=np.vstack(H))
        means.append(kf.x.copy())
        Ps.append(kf.P.copy())
    means, Ps = np.array(means), np.array(Ps)
    # filterpy takes F and Q of a step at its end; the first sample has none.
    smoothed, P, _, _ = kf.rts_smoother(means, Ps, Fs=[Fs[0], *Fs], Qs=[Qs[0], *Qs])
    found = solve_linearized(data, PriorEstimate.from_suite(data.suite), at, parts)
    both = compute_covariances(found, collect_covariances(found, len(parts.stochastic)))
    sigma = np.sqrt(np.einsum("kii->ki", P))
    d = parts.stochastic
    np.testing.assert_allclose(
        (found.stochastic_errors - smoothed[:, d]) / sigma[:, d], 0.0, atol=1e-9
    )
    c = parts.constant
    np.testing.assert_allclose(
        (found.constant_errors - smoothed[-1, c]) / sigma[-1, c], 0.0, atol=1e-9
    )
    for k in range(STEPS + 1):
        scale = np.outer(sigma[k, d], sigma[k, d])
        own = both[k] / scale
        np.testing.assert_allclose(own, P[k][np.ix_(d, d)] / scale, rtol=0, atol=1e-9)


@pytest.mark.parametrize("name", ["paper", "full gyro", "varying errors", "cubesat_6u_full"])
def test_filter_and_innovations_agree_with_sequential_filter(name):
    """The filter for a known c plus its dependence on c, against a Kalman filter of all states."""
    data, at = build_batch_near_truth(build_scenario(name, **MEMS))
    data = dataclasses.replace(data, breaks=np.zeros_like(data.breaks))
    sigma, parts = data.suite.initial_sigma(1.0), Partition.from_suite(data.suite)
    found = solve_linearized(data, PriorEstimate.from_suite(data.suite), at, parts)
    move, (N, d) = linearize_process(data, at, parts), found.stochastic_errors.shape
    past = compute_filter_estimates(found, d)
    errors, P_driven = past.errors, past.covariances
    r, J = PriorEstimate.from_suite(data.suite).compute_residual(at.attitude[0], at.states[0])
    J = J[:, [*parts.stochastic, *parts.constant]]
    P = np.linalg.inv(J.T @ J)
    x, q = P @ J.T @ r, len(sigma)
    for k in range(N):
        if k:
            F, Q = np.eye(q), np.zeros((q, q))
            F[:d, :d], F[:3, d:], Q[:d, :d] = move.F[k - 1], move.G[k - 1], move.Q[k - 1]
            x = F @ x
            x[:d] += move.defect[k - 1]
            P = F @ P @ F.T + Q
        for index, each in enumerate(past.innovations):
            seen = linearize_sensor(data, index, at)
            (row,) = np.flatnonzero(seen.samples == k)
            H = np.zeros((3, q))
            for column, state in zip(seen.H[row].T, seen.states, strict=True):
                if state in parts.stochastic:
                    H[:, np.flatnonzero(parts.stochastic == state)[0]] = column
                else:
                    place = np.flatnonzero(parts.constant == state)[0]
                    H[:, d + place] = column * move.constant_factors[k, place]
            noise = np.diag(seen.noise**2)
            L = np.linalg.cholesky(H @ P @ H.T + noise)
            w = np.linalg.solve(L, seen.z[row] - H @ x)
            np.testing.assert_allclose(each.whitened_values[row], w, rtol=0, atol=1e-8)
            gain = P @ H.T @ np.linalg.inv(H @ P @ H.T + noise)
            x = x + gain @ (seen.z[row] - H @ x)
            P = (np.eye(q) - gain @ H) @ P
        unit = np.sqrt(np.diag(P))
        np.testing.assert_allclose((errors[k] - x[:d]) / unit[:d], 0.0, atol=1e-8)
        scale = np.outer(unit, unit)
        np.testing.assert_allclose(
            P_driven[k] / scale[:d, :d], P[:d, :d] / scale[:d, :d], rtol=0, atol=1e-8
        )
    np.testing.assert_allclose((found.constant_errors - x[d:]) / unit[d:], 0.0, atol=1e-8)
    known = compute_covariances(found, collect_covariances(found, d))
    np.testing.assert_allclose(P_driven[-1], known[-1], rtol=1e-6)


def build_initial_trajectory(data, of):
    from mgeo_calibration.estimation.initial_attitude import estimate_initial_attitude

    zero = np.zeros((len(data.times), data.suite.n_states))
    return Trajectory(estimate_initial_attitude(data, zero)[0], zero)


def compute_rotation_between(measured, predicted):
    """Return the vector between unit vectors along the great circle, with the length of twice the
    tangent of half the angle.
    """
    predicted = predicted / np.linalg.norm(predicted, axis=1, keepdims=True)
    cosine = (measured * predicted).sum(axis=1, keepdims=True)
    across = measured * cosine - predicted
    sine = np.linalg.norm(across, axis=1, keepdims=True)
    return 2.0 * np.tan(0.5 * np.arctan2(sine, cosine)) * across / sine


@pytest.mark.parametrize("sun", [SunSensor(), TwoAxisSunSensor(noise_deg=2.0)])
def test_optimum_agrees_with_scipy_optimizer(sun):
    """The residuals are computed independently with scipy's rotations, and derivatives by
    differences.
    """
    of = short(build_scenario("paper", bias_decay=0.0), 12.0)
    of = dataclasses.replace(of, sensors=(sun, of.sensors[1]))
    data = build_batch(of, simulate_from_any_attitude(of, 5, plan=PLAN))
    suite, sigma, N = data.suite, data.suite.initial_sigma(1.0), len(data.times)
    found = solve(
        data, PriorEstimate.from_suite(suite), build_initial_trajectory(data, of), 30, (1e-4, 1e-9)
    )
    start = found.estimate
    _, Q = discretize_van_loan(FilterModel.from_scenario(of), np.zeros(3))
    root = np.linalg.inv(np.linalg.cholesky(Q[:6, :6]))
    at = Rotation.from_matrix(start.attitude)

    def gibbs(rotation):
        x, y, z, w = np.moveaxis(rotation.as_quat(), -1, 0)
        return 2.0 * np.stack([x, y, z], axis=-1) / w[..., None]

    def turned(g):
        return Rotation.from_quat(np.concatenate([0.5 * g, np.ones((*g.shape[:-1], 1))], axis=-1))

    def residuals(flat):
        e, bias = flat[: 3 * N].reshape(N, 3), flat[3 * N : 6 * N].reshape(N, 3) * sigma[3]
        constants = flat[6 * N :] * sigma[6:]
        R = at * turned(e)
        propagated = R[:-1] * Rotation.from_rotvec(data.gyro_rates - bias[:-1])
        defect = np.hstack([gibbs(R[1:].inv() * propagated), bias[:-1] - bias[1:]])
        parts = [(defect @ root.T).ravel(), flat[3 * N : 3 * N + 3], flat[6 * N :]]
        for index, sensor in enumerate(suite.sensors):
            mu, b = constants[6 * index : 6 * index + 3], constants[6 * index + 3 : 6 * index + 6]
            seen = turned(mu).apply(R.inv().apply(data.vectors[:, index])) + b
            off = compute_rotation_between if sensor.has_unit_length else np.subtract
            parts.append((off(data.readings[index][:, 0], seen) / sensor.noise_sigmas()[0]).ravel())
        return np.concatenate(parts)

    x0 = np.concatenate(
        [np.zeros(3 * N), start.states[:, 3:6].ravel() / sigma[3], start.states[0, 6:] / sigma[6:]]
    )
    best = least_squares(residuals, x0, jac="3-point", xtol=1e-15, ftol=1e-15, gtol=1e-12)
    assert (residuals(x0) ** 2).sum() == pytest.approx(found.cost, rel=1e-6)
    assert 2.0 * best.cost == pytest.approx(found.cost, rel=1e-6)
    moved = best.x - x0
    np.testing.assert_allclose(moved[: 3 * N], 0.0, atol=1e-6)
    # Difference in prior 1-sigmas; the 1-sigmas of the estimate are 0.1 to 1 of these.
    np.testing.assert_allclose(moved[3 * N :], 0.0, atol=1e-4)
