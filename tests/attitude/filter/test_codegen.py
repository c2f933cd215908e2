"""The generated filter step, executed as plain Python."""

from math import sqrt

import numpy as np
import pytest
from mgeo_attitude.filter.codegen import CHECK_PART, build_step_parts, compute_instrument_constants
from mgeo_attitude.filter.layout import (
    build_layout,
    compute_transition_pattern,
    is_disc,
    list_directions,
)
from mgeo_attitude.filter.reference import update_with_considered_states
from scipy.linalg import block_diag

from .suites import SUITES, every_suite

STEP = 2.0


@pytest.mark.cases(3)
@every_suite
def test_generated_step_is_one_filter_step(name):
    """The expected result is computed by equations (3) and (4) with dense matrices."""
    suite, rng = SUITES[name], np.random.default_rng(0)
    gated = tuple(index == 0 for index in range(len(suite.sensors)))
    at, n = build_layout(suite, gated), suite.n_states
    m, k = suite.n_dynamic, suite.n_kinematic
    names, blind = list_directions(suite), []
    parts, lanes = build_step_parts(suite, gated), 8
    assert list(parts)[-1] == CHECK_PART
    weights = rng.uniform(0.5, 2.0, n)
    constants, step = np.append(compute_instrument_constants(suite, STEP), weights), STEP
    decays = [np.exp(-step / each.correlation_time) for each in suite.processes.values()]
    sigmas = [np.broadcast_to(each.sigma, 3) for each in suite.processes.values()]
    W = np.zeros((at.constants + len(constants), lanes))
    W[at.constants :] = constants[:, None]
    pattern = compute_transition_pattern(suite)
    expected = []
    for lane in range(lanes):
        root = rng.standard_normal((n, n))
        P = root @ root.T
        F = np.eye(m)
        for i, j in pattern:
            F[i, j] = rng.standard_normal()
        noisy = np.isin(np.arange(m), [i for i, _ in pattern])
        Q = np.cov(rng.standard_normal((m, 3 * m))) * np.outer(noisy, noisy)
        F[k:, k:] = np.diag(np.repeat(decays, 3))
        Q[k:, k:] = np.diag(np.ravel(sigmas) ** 2 * (1.0 - np.repeat(decays, 3) ** 2))
        C, dC = (np.linalg.qr(rng.standard_normal((3, 3)))[0] for _ in range(2))
        references = rng.standard_normal((suite.n_vectors, 3))
        vectors = rng.standard_normal((len(names), 3))
        vectors /= np.linalg.norm(vectors, axis=1, keepdims=True)
        limb, rate = rng.uniform(0.2, 1.0), rng.uniform(0.0, 0.02)
        directions = dict(zip(names, vectors, strict=True))
        gate = float(lane % 2)  # The first sensor is unavailable in every second lane.
        W[: at.attitude, lane] = P[np.tril_indices(n)]
        W[at.attitude : at.monitors, lane] = C.ravel()
        W[at.rotation : at.F, lane] = dC.ravel()
        W[at.F : at.Q, lane] = [F[i, j] for i, j in pattern]
        W[at.Q : at.axis_angle, lane] = Q[np.tril_indices(k)]
        omega = rng.standard_normal(3)
        W[at.squared_rate : at.body_rate, lane] = rate**2
        W[at.body_rate : at.trace, lane] = omega[: at.trace - at.body_rate]
        views = [
            number
            for name, vector in directions.items()
            for number in (*vector, *([np.cos(limb), np.sin(limb)] if is_disc(name) else []))
        ]
        follows = rng.standard_normal(len(suite.sensitivities_by_key))
        W[at.table : at.constants, lane] = [*references.ravel(), *views, *follows, gate]
        for columns, value in zip(suite.gyro_sensitivity_slices, follows, strict=False):
            F[:3, columns] *= value

        full = block_diag(F, np.eye(n - m))
        P = full @ P @ full.T + block_diag(Q, np.zeros((n - m, n - m)))
        for index, sensor in enumerate(suite.sensors):
            v = dC @ C @ references[index]
            hidden = rate > sensor.get_max_rate()
            for view in sensor.list_visibility_cones():
                looked_at = dC @ C @ directions[view.direction] if view.direction else v
                angle = np.arccos(np.clip(looked_at @ view.axis, -1.0, 1.0)) - limb * view.is_disc
                hidden |= (angle > view.half_angle) == view.keep_in
            blind.append(hidden)
            if (index == 0 and not gate) or hidden:
                continue
            auxiliary_vectors = references[suite.find_auxiliary_rows(index)] @ (dC @ C).T
            own = follows[suite.find_sensitivity_columns(sensor)]
            H = suite.measurement_matrix(sensor, v, dC @ C, auxiliary_vectors, omega, own)
            P = update_with_considered_states(
                P, H, np.diag(np.square(sensor.noise_sigmas())), suite.considered_indices
            )
        expected.append((P, dC @ C, weights @ np.diag(P)))
    if names:
        assert len(set(blind[::2])) == 2  # The star tracker measures in some lanes only.
    for lane, (P, C, trace) in enumerate(expected):
        values = W[:, lane].copy()
        for text in parts.values():
            exec(text, {"sqrt": sqrt, "W": values})
        scale = np.abs(P).max()
        np.testing.assert_allclose(
            values[: at.attitude], P[np.tril_indices(n)], rtol=0, atol=1e-9 * scale
        )
        np.testing.assert_allclose(values[at.attitude : at.monitors], C.ravel(), atol=1e-14)
        assert values[at.trace] == pytest.approx(trace, abs=1e-9 * scale)
        assert values[at.pivot] == pytest.approx(np.linalg.cholesky(P)[-1, -1], rel=1e-6)
