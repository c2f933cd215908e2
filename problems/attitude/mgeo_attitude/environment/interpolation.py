"""Piecewise polynomial interpolation of samples: Hermite with slopes, Lagrange without.

The polynomials use Newton's divided differences, in which a sample with a slope is a double node
(Burden & Faires, Numerical Analysis, section 3.4). All instants are evaluated at once, since one
scipy polynomial per window takes seconds for samples of a few hours at 1 s. As in CCSDS 502.0-B and
most tools, the samples are centered at the instant, except near either end.
"""

from __future__ import annotations

import numpy as np

from mgeo_attitude._typing import Floats, Ints


def interpolate(
    times: Floats,
    values: Floats,
    slopes: Floats | None,
    n_samples: int,
    output_times: Floats,
    shift: int = 0,
) -> tuple[Floats, Floats]:
    """Return value and derivative of the interpolated function, both of shape (k, 3).

    Parameters
    ----------
    times : array, shape (n,)
        Times of the samples, increasing.
    values : array, shape (n, 3)
    slopes : array, shape (n, 3), optional
        Derivatives of the values.
    n_samples : int
        Number of samples per polynomial, at most n. The degree is count - 1, or 2 count - 1 with
        slopes.
    at : array, shape (k,)
        Times of the results.
    shift : int
        Number of samples by which the windows are shifted forward. Windows that would leave the
        samples are shifted backward.
    """
    first, last = _find_first_samples(times, output_times, n_samples), len(times) - n_samples
    first = np.where(first + shift <= last, first + shift, np.maximum(first - shift, 0))
    rows = first[:, None] + np.arange(n_samples)
    repeats = 1 if slopes is None else 2
    nodes = np.repeat(
        times[rows] - output_times[:, None], repeats, axis=1
    )  # results are taken at zero
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


def _find_first_samples(times: Floats, output_times: Floats, n_samples: int) -> Ints:
    """Return the first of the `n_samples` samples around each instant."""
    if n_samples % 2:  # around the nearest sample
        middle = np.searchsorted(0.5 * (times[1:] + times[:-1]), output_times)
    else:  # around the interval
        middle = np.searchsorted(times, output_times, side="right")
    return np.asarray(np.clip(middle - n_samples // 2, 0, len(times) - n_samples))
