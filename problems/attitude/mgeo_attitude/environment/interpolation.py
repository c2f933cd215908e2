"""Polynomials through samples of a position, and perhaps of its velocity, on arrays of times.

Newton's divided differences; a sample with a velocity is a double node (Burden & Faires, Numerical
Analysis, section 3.4). Lagrange's and Hermite's polynomials are the same, written otherwise.
"""

from __future__ import annotations

import numpy as np

from mgeo_attitude._typing import Floats, Ints


def nearest(times: Floats, at: Floats, count: int) -> Ints:
    """Which `count` of the increasing times [s] lie around each of `at` (k,), shape (k, count).

    As many before as after it, but near either end.
    """
    if count % 2:  # around the nearest sample
        middle = np.searchsorted(0.5 * (times[1:] + times[:-1]), at)
    else:  # around the interval
        middle = np.searchsorted(times, at, side="right")
    first = np.clip(middle - count // 2, 0, len(times) - count)
    return np.asarray(first)[:, None] + np.arange(count)


def others(n: int, count: int) -> Ints:
    """Which `count` of n samples lie around each of them, itself left out, shape (n, count)."""
    own = np.arange(n)[:, None]
    rows = np.clip(own - count // 2, 0, n - 1 - count) + np.arange(count)
    return np.asarray(rows + (rows >= own))


def interpolate(
    times: Floats, values: Floats, slopes: Floats | None, rows: Ints, at: Floats
) -> tuple[Floats, Floats]:
    """Value and slope, both (k, 3), at times `at` (k,), of polynomials through the samples `rows`.

    Samples are `values`, and where given `slopes`, of shape (n, 3), at `times` (n,); each row of
    `rows`, shape (k, m), names those of one polynomial. Its degree is m - 1, with slopes 2 m - 1.
    """
    multiplicity = 1 if slopes is None else 2
    # from the wanted instant, so that it is at zero
    nodes = np.repeat(times[rows] - at[:, None], multiplicity, axis=1)
    terms = np.repeat(values[rows], multiplicity, axis=1)
    n = nodes.shape[1]
    for order in range(1, n):
        span = (nodes[:, order:] - nodes[:, :-order])[:, :, None]
        rise = terms[:, order:] - terms[:, order - 1 : -1]
        if slopes is not None and order == 1:
            span[:, ::2], rise[:, ::2] = 1.0, slopes[rows]
        terms[:, order:] = rise / span
    value, slope = terms[:, -1], np.zeros_like(terms[:, -1])
    for k in range(n - 2, -1, -1):
        offset = -nodes[:, k, None]
        slope = value + offset * slope
        value = terms[:, k] + offset * value
    return value, slope
