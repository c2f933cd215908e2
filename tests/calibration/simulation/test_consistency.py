"""Consistency tests of random results with a known distribution."""

import dataclasses

import numpy as np
import pytest
from mgeo_calibration import MonteCarloResult, evaluate_consistency

N, M = 200, 40


@pytest.fixture(scope="module")
def result():
    """Errors with the distribution that the filter predicts, constant in time like calibration
    parameters.
    """
    rng = np.random.default_rng(4)
    errors = np.repeat(rng.standard_normal((N, 1, 6)), M, axis=1)
    return MonteCarloResult(
        blocks=("attitude", "gyro.bias"),
        n_components=(3, 3),
        sensors=("sun", "blind"),
        design=np.zeros(4),
        t_end=20.0,
        times=np.arange(M, dtype=float),
        predicted_sigma=np.ones((M, 6)),
        errors=errors,
        sigma=np.ones((N, M, 6)),
        nees=(errors**2).sum(axis=2),
        nis=np.stack([rng.chisquare(30, (N, M)), np.zeros((N, M))], axis=2),
        n_innovations=np.stack([np.full((N, M), 10), np.zeros((N, M), dtype=int)], axis=2),
        path_constraints=(),
        violated_fractions=np.zeros((N, 2, 0)),
    )


def test_consistent_errors_pass(result):
    report = evaluate_consistency(result)
    assert report["passed"].all(), report
    assert list(report.index) == [
        "nees",
        "nis sun",
        "beyond 3 sigma",
        "smallest rms / predicted",
        "largest rms / predicted",
    ]


def test_nees_bounds_are_chi_square_quantiles(result):
    """The expected quantiles are the approximation of Wilson and Hilferty."""
    bounds = evaluate_consistency(result).loc["nees"]
    dof, z = 6 * N, 2.5758293035489004
    expected = [(1 - 2 / (9 * dof) + sign * z * np.sqrt(2 / (9 * dof))) ** 3 for sign in (-1, 1)]
    np.testing.assert_allclose([bounds.low, bounds.high], expected, rtol=1e-4)


@pytest.mark.parametrize(
    ("criterion", "changes"),
    [
        ("nees", {"nees": 1.2}),
        ("nees", {"nees": 0.8}),
        ("nis sun", {"nis": 1.03}),
        ("beyond 3 sigma", {"sigma": 0.6}),
        ("largest rms / predicted", {"errors": 1.2}),
        ("smallest rms / predicted", {"errors": 0.8}),
        ("nees", {"nees": np.nan}),
    ],
)
def test_inconsistent_statistics_fail(result, criterion, changes):
    wrong = {name: factor * getattr(result, name) for name, factor in changes.items()}
    report = evaluate_consistency(dataclasses.replace(result, **wrong))
    assert not report.loc[criterion, "passed"]
    assert not report["passed"].all()


def test_invalid_arguments_raise(result):
    with pytest.raises(ValueError, match=r"start_time = 50\.0: expected at most 39\.0 s"):
        evaluate_consistency(result, start_time=50.0)
    with pytest.raises(ValueError, match="confidence = 99"):
        evaluate_consistency(result, confidence=99)
