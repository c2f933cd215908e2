"""Interpolating polynomials compared with scipy."""

from __future__ import annotations

import numpy as np
import pytest
from mgeo_attitude.environment.interpolation import interpolate
from scipy.interpolate import BarycentricInterpolator, KroghInterpolator

TIMES = np.array([0.0, 50.0, 130.0, 180.0, 240.0, 330.0, 360.0, 420.0, 500.0])
#: Output times, and the first of the three and of the four samples around each.
AT = np.array([0.0, 12.0, 131.0, 287.3, 419.0, 499.0])
FIRST = {3: [0, 0, 1, 4, 6, 6], 4: [0, 0, 1, 3, 5, 5]}
PHASES = np.array([90.0, 110.0, 170.0])


def wave(times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    phase = times[:, None] / PHASES + np.array([0.0, 1.0, 2.0])
    return np.sin(phase), np.cos(phase) / PHASES


@pytest.mark.parametrize("shift", [0, 1])
@pytest.mark.parametrize("count", FIRST)
@pytest.mark.parametrize("with_slopes", [False, True])
def test_interpolation_equals_scipy(count: int, with_slopes: bool, shift: int) -> None:
    values, slopes = wave(TIMES)
    value, slope = interpolate(TIMES, values, slopes if with_slopes else None, count, AT, shift)
    for k, first in enumerate(FIRST[count]):
        first += shift if first + shift <= len(TIMES) - count else -shift
        rows = slice(first, first + count)
        expected = BarycentricInterpolator(TIMES[rows], values[rows])
        if with_slopes:
            both = np.stack([values[rows], slopes[rows]], axis=1).reshape(-1, 3)
            expected = KroghInterpolator(np.repeat(TIMES[rows], 2), both)
        np.testing.assert_allclose(value[k], expected(AT[k]), rtol=0.0, atol=1e-12)
        np.testing.assert_allclose(slope[k], expected.derivative(AT[k]), rtol=0.0, atol=1e-12)
