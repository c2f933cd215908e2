"""Polynomials through samples, against scipy's and against what they must reproduce."""

from __future__ import annotations

import numpy as np
import pytest
from mgeo_attitude.environment.arc import interpolate, nearest, others
from scipy.interpolate import BarycentricInterpolator, KroghInterpolator

TIMES = np.array([0.0, 50.0, 130.0, 180.0, 240.0, 330.0, 360.0, 420.0, 500.0])
AT = np.array([0.0, 12.0, 130.0, 131.0, 287.3, 420.0, 499.0, 500.0])


def wave(times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    phase = times[:, None] / np.array([90.0, 110.0, 170.0]) + np.array([0.0, 1.0, 2.0])
    return np.sin(phase), np.cos(phase) / np.array([90.0, 110.0, 170.0])


@pytest.mark.parametrize("count", [2, 3, 4, 8, 9])
def test_lagrange_against_scipy(count: int) -> None:
    values, _ = wave(TIMES)
    rows = nearest(TIMES, AT, count)
    found, slope = interpolate(TIMES, values, None, rows, AT)
    for k, row in enumerate(rows):
        expected = BarycentricInterpolator(TIMES[row], values[row])
        np.testing.assert_allclose(found[k], expected(AT[k]), rtol=0.0, atol=1e-12)
        np.testing.assert_allclose(slope[k], expected.derivative(AT[k]), rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("count", [1, 2, 3, 4, 7])
def test_hermite_against_scipy(count: int) -> None:
    values, slopes = wave(TIMES)
    rows = nearest(TIMES, AT, count)
    found, slope = interpolate(TIMES, values, slopes, rows, AT)
    for k, row in enumerate(rows):
        both = np.stack([values[row], slopes[row]], axis=1).reshape(-1, 3)
        expected = KroghInterpolator(np.repeat(TIMES[row], 2), both)
        np.testing.assert_allclose(found[k], expected(AT[k]), rtol=0.0, atol=1e-12)
        np.testing.assert_allclose(slope[k], expected.derivative(AT[k]), rtol=0.0, atol=1e-12)


def test_samples_are_met_exactly() -> None:
    values, slopes = wave(TIMES)
    for given in (None, slopes):
        found, _ = interpolate(TIMES, values, given, nearest(TIMES, TIMES, 4), TIMES)
        np.testing.assert_allclose(found, values, rtol=0.0, atol=1e-15)


def test_neighbors_lie_evenly_around() -> None:
    times = np.arange(6.0)
    at = np.array([-0.5, 0.4, 2.2, 2.8, 5.0])
    assert nearest(times, at, 2)[:, 0].tolist() == [0, 0, 2, 2, 4]
    assert nearest(times, at, 3)[:, 0].tolist() == [0, 0, 1, 2, 3]
    assert nearest(times, at, 4)[:, 0].tolist() == [0, 0, 1, 1, 2]


def test_others_leave_out_the_sample_itself() -> None:
    assert others(5, 2).tolist() == [[1, 2], [0, 2], [1, 3], [2, 4], [2, 3]]
    assert others(3, 2).tolist() == [[1, 2], [0, 2], [0, 1]]
