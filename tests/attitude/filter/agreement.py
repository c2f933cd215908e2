"""Random designs, and comparisons of the compiled filter with the reference filter."""

import numpy as np
import pytest
from mgeo_attitude import evaluate, run_filter, run_reference_filter


def designs(rng, n, max_duration=2000.0):
    """Return random designs of three maneuvers, shape (n, 12)."""
    X = rng.uniform(-1.0, 1.0, (n, 12))
    X[:, 3::4] = rng.uniform(0.0, max_duration, (n, 3))
    return X


def special_designs(rng):
    """Return designs with durations and rates at their bounds, and with fractions of a step."""
    X = designs(rng, 14)
    X[0, 3::4] = 0.0
    X[1, 3::4] = 500.0
    X[2, 3::4] = 2000.0
    X[3, 3::4] = [0.0, 700.0, 0.0]
    X[4, 3::4] = [300.0, 0.0, 0.0]
    X[5, 3::4] = [0.25, 0.25, 0.25]
    X[6, 3::4] = [100.5, 200.25, 99.999]
    X[7] = 0.0
    rates = np.arange(12) % 4 != 3
    X[8, rates] = 1.0
    X[9, rates] = -1.0
    X[10, rates] = 0.0
    X[11, rates] = np.tile([1.0, -1.0, 0.0], 3)
    X[12, rates] = 1e-9
    X[13, 3::4] = [2000.0, 2000.0, 1.0]
    return X


def assert_agrees(model, X):
    result = evaluate(model, X, history=True)
    for x, t_end, trace, variances in zip(
        X, result.t_end, result.trace, result.variances, strict=True
    ):
        history = run_reference_filter(model, x)
        assert t_end == history.t_end
        assert trace == pytest.approx(history.trace[-1], rel=1e-9)
        n = len(history.times)
        np.testing.assert_allclose(variances[:n], history.sigma**2, rtol=1e-9)
        assert np.isnan(variances[n:]).all()


def assert_same_history(model, x):
    """Assert that both filters give the same history, except for rounding."""
    history, expected = run_filter(model, x), run_reference_filter(model, x)
    assert history.converged == expected.converged
    assert history.blocks == expected.blocks
    for name in ("times", "trace", "sigma", "attitude", "covariance"):
        value, reference = getattr(history, name), getattr(expected, name)
        np.testing.assert_allclose(
            value, reference, rtol=1e-9, atol=1e-12 * np.abs(reference).max()
        )
