"""Polynomials through the samples around each instant: Hermite's with slopes, Lagrange's without.

Newton's divided differences, where a sample with a slope is a double node (Burden & Faires,
Numerical Analysis, section 3.4), of all instants at once: a polynomial of scipy's for each window
takes seconds for samples of a few hours at 1 s. Which samples a polynomial goes through is as CCSDS
502.0-B and most tools have it: as many before as after the instant, but near either end.
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
    first, last = _first_samples(times, at, count), len(times) - count
    first = np.where(first + shift <= last, first + shift, np.maximum(first - shift, 0))
    rows = first[:, None] + np.arange(count)
    repeats = 1 if slopes is None else 2
    nodes = np.repeat(times[rows] - at[:, None], repeats, axis=1)  # the wanted instant is at zero
    terms = np.repeat(values[rows], repeats, axis=1)
    for order in range(1, nodes.shape[1]):
        span = (nodes[:, order:] - nodes[:, :-order])[:, :, None]
        rise = terms[:, order:] - terms[:, order - 1 : -1]
        if slopes is not None and order == 1:
            span[:, ::2], rise[:, ::2] = 1.0, slopes[rows]
        terms[:, order:] = rise / span
    value, slope = terms[:, -1], np.zeros_like(terms[:, -1])
    for k in range(nodes.shape[1] - 2, -1, -1):
        slope = value - nodes[:, k, None] * slope
        value = terms[:, k] - nodes[:, k, None] * value
    return value, slope


def _first_samples(times: Floats, at: Floats, count: int) -> Ints:
    """Return the first of the `count` samples around each instant."""
    if count % 2:  # around the nearest sample
        middle = np.searchsorted(0.5 * (times[1:] + times[:-1]), at)
    else:  # around the interval
        middle = np.searchsorted(times, at, side="right")
    return np.asarray(np.clip(middle - count // 2, 0, len(times) - count))
