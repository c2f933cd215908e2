"""Piecewise polynomial interpolation of samples: Hermite with derivatives, Lagrange without.

The polynomials use Newton's divided differences, in which a sample with a derivative is a double
node (Burden & Faires, Numerical Analysis, section 3.4). All instants are evaluated at once, since
one scipy polynomial per window takes seconds for samples of a few hours at 1 s. As in CCSDS 502.0-B
and most tools, the samples of a polynomial are centered at the instant, except near the first and
the last sample.
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
    """Interpolate samples by piecewise polynomials, and return values and derivatives.

    Both results have shape (k, 3). Hermite polynomials are used if the derivatives of the samples
    are given, and Lagrange polynomials otherwise.

    Parameters
    ----------
    times : array, shape (n,)
        Times of the samples, increasing.
    values : array, shape (n, 3)
        Values of the samples.
    slopes : array, shape (n, 3), optional
        Derivatives of the values.
    n_samples : int
        Number of samples per polynomial, at most n. The degree is n_samples - 1, or 2 n_samples - 1
        with slopes.
    output_times : array, shape (k,)
        Times of the results.
    shift : int
        Number of samples by which the window of each polynomial is shifted forward, to compare
        interpolations. Windows that would exceed the samples are shifted backward.
    """
    first, last = _find_first_samples(times, output_times, n_samples), len(times) - n_samples
    first = np.where(first + shift <= last, first + shift, np.maximum(first - shift, 0))
    rows = first[:, None] + np.arange(n_samples)
    repeats = 1 if slopes is None else 2
    # Times are relative to the output time, so that the polynomials are evaluated at zero.
    nodes = np.repeat(times[rows] - output_times[:, None], repeats, axis=1)
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
    """Return, for each output time, the index of the first sample in the interpolation window."""
    if n_samples % 2:  # The window is centered at the nearest sample.
        middle = np.searchsorted(0.5 * (times[1:] + times[:-1]), output_times)
    else:  # The window is centered at the interval.
        middle = np.searchsorted(times, output_times, side="right")
    return np.asarray(np.clip(middle - n_samples // 2, 0, len(times) - n_samples))
