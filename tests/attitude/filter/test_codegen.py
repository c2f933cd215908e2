"""The generated step, run as plain Python, and the symbols that write it."""

from math import sqrt

import numpy as np
import pytest
from mgeo_attitude.filter.codegen import CHECK, module_source, step_constants, step_parts
from mgeo_attitude.filter.layout import NO_MONITORS, layout
from mgeo_attitude.filter.symbols import Symbol, SymbolArithmetic
from scipy.linalg import block_diag

from .suites import SUITES

a, b, c = Symbol("a"), Symbol("b"), Symbol("c")
VALUES = {"a": 2.0, "b": -3.0, "c": 7.0}


@pytest.mark.parametrize(
    ("expression", "expected"),
    [
        (a + b * c, -19.0),
        ((a + b) * c, -7.0),
        (c * (a - b), 35.0),
        (a - (b - c), 12.0),
        (a - (b + c) * 2.0, -6.0),
        (-(a + b), 1.0),
        (-a * b, 6.0),
        (a - -b, -1.0),
        (1.0 / (a * b), -1.0 / 6.0),
        (1.5 - a, -0.5),
        (2.0 - (a - b), -3.0),
        (0.0 - a, -2.0),
        (3.0 + a, 5.0),
        (sum([a, b, c]), 6.0),
    ],
)
def test_symbols_mean_what_their_arithmetic_means(expression, expected):
    assert eval(expression.text, {}, VALUES) == pytest.approx(expected, rel=1e-15)


def test_zeros_and_ones_fold_away():
    assert a * 0.0 == 0.0 * a == 0.0
    for folded in (a * 1.0, 1.0 * a, a + 0.0, 0.0 + a, a - 0.0):
        assert folded is a


def test_keep_names_only_what_is_no_name():
    ops = SymbolArithmetic()
    assert ops.keep(a) is a
    assert ops.keep(1.0) == 1.0
    assert ops.keep(a + b).text == "t1"
    assert ops.lines == ["t1 = a + b"]


@pytest.mark.parametrize("name", SUITES)
def test_generated_step_is_one_filter_step(name):
    """Equations (3) and (4) by dense algebra, all sensors together, against the text's result."""
    suite, rng = SUITES[name], np.random.default_rng(0)
    gated = tuple(index == 0 for index in range(len(suite.sensors)))
    at, n, m = layout(suite, gated), suite.n_states, suite.n_dynamic
    parts, lanes = step_parts(suite, gated), 2
    assert list(parts)[-1] == CHECK
    W = np.zeros((at.total, lanes))
    weights = rng.uniform(0.5, 2.0, n)
    expected = []
    for lane in range(lanes):
        root = rng.standard_normal((n, n))
        P = root @ root.T
        F = np.eye(m)
        for i, j in at.transition:
            F[i, j] = rng.standard_normal()
        noisy = np.isin(np.arange(m), [i for i, _ in at.transition])
        Q = np.cov(rng.standard_normal((m, 3 * m))) * np.outer(noisy, noisy)
        C, dC = (np.linalg.qr(rng.standard_normal((3, 3)))[0] for _ in range(2))
        references = rng.standard_normal((len(suite.sensors), 3))
        gate = float(lane)  # the first sensor is off in the first lane
        W[: at.attitude, lane] = P[np.tril_indices(n)]
        W[at.attitude : at.rotation, lane] = C.ravel()
        W[at.rotation : at.F, lane] = dC.ravel()
        W[at.F : at.Q, lane] = [F[i, j] for i, j in at.transition]
        W[at.Q : at.trace, lane] = Q[np.tril_indices(m)]

        full = block_diag(F, np.eye(n - m))
        P = full @ P @ full.T + block_diag(Q, np.zeros((n - m, n - m)))
        for index, sensor in enumerate(suite.sensors):
            v = dC @ C @ references[index]
            view = sensor.field_of_view()
            if (index == 0 and not gate) or (view and v @ view[0] < np.cos(view[1])):
                continue
            H, R = suite.measurement_matrix(sensor, v), np.diag(np.square(sensor.noise()))
            P = P - P @ H.T @ np.linalg.solve(R + H @ P @ H.T, H @ P)
        expected.append((P, dC @ C, weights @ np.diag(P), [*references.ravel(), gate]))
    for lane, (P, C, trace, row) in enumerate(expected):
        values = W[:, lane].copy()
        for text in parts.values():
            constants = step_constants(suite, weights)
            exec(text, {"sqrt": sqrt, "W": values, "C": constants, "R": row})
        scale = np.abs(P).max()
        np.testing.assert_allclose(
            values[: at.attitude], P[np.tril_indices(n)], rtol=0, atol=1e-9 * scale
        )
        np.testing.assert_allclose(values[at.attitude : at.rotation], C.ravel(), atol=1e-14)
        assert values[at.trace] == pytest.approx(trace, abs=1e-9 * scale)
        assert values[at.pivot] == pytest.approx(np.linalg.cholesky(P)[-1, -1], rel=1e-6)


def test_module_source_does_not_change_from_run_to_run():
    suite = SUITES["paper"]
    first = module_source(suite, (False, False), NO_MONITORS, 8, cache=True)
    assert first == module_source(suite, (False, False), NO_MONITORS, 8, cache=True)
    assert "W[0]" in first
