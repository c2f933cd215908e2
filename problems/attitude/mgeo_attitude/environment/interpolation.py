"""Polynomials through the samples around each instant: Hermite's with slopes, Lagrange's without.

The polynomials are scipy's (`KroghInterpolator`: Newton's form, a sample with a slope is a double
node). Which samples each goes through is as CCSDS 502.0-B and most tools have it: as many before as
after the instant, but near either end.
"""

from __future__ import annotations

import numpy as np

from mgeo_attitude._typing import Floats, Ints


def interpolate(
    times: Floats,
    values: Floats,
    slopes: Floats | None,
    count: int,
    at: Floats,
    shift: int = 0,
) -> tuple[Floats, Floats]:
    """Return value and slope, both (k, 3), at times `at` (k,).

    Parameters
    ----------
    times : array, shape (n,)
        Increasing.
    values : array, shape (n, 3)
    slopes : array, shape (n, 3), optional
    count : int
        Number of samples that each polynomial goes through, at most n; its degree is count - 1,
        with slopes 2 count - 1.
    at : array, shape (k,)
    shift : int
        Number of samples by which to move the windows, toward the other side where they would
        leave the samples.
    """
    from scipy.interpolate import KroghInterpolator  # which takes long to import

    first = _first_samples(times, at, count)
    last = len(times) - count
    first = np.where(first + shift <= last, first + shift, np.maximum(first - shift, 0))
    repeats = 1 if slopes is None else 2
    nodes = np.repeat(times, repeats)
    data = values if slopes is None else np.stack([values, slopes], axis=1).reshape(-1, 3)
    value, slope = np.empty((len(at), 3)), np.empty((len(at), 3))
    for start in np.unique(first).tolist():
        own = first == start
        window = slice(repeats * start, repeats * (start + count))
        polynomial = KroghInterpolator(nodes[window] - times[start], data[window])
        value[own], slope[own] = polynomial.derivatives(at[own] - times[start], 2)
    return value, slope


def _first_samples(times: Floats, at: Floats, count: int) -> Ints:
    """Return the first of the `count` samples around each instant."""
    if count % 2:  # around the nearest sample
        middle = np.searchsorted(0.5 * (times[1:] + times[:-1]), at)
    else:  # around the interval
        middle = np.searchsorted(times, at, side="right")
    return np.asarray(np.clip(middle - count // 2, 0, len(times) - count))
