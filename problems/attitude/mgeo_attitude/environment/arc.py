"""Samples of a motion without a jump of velocity in it, and the polynomials through them.

The acceleration may jump: thrust begins and ends. Across that a polynomial of high degree is off by
kilometers where steps differ in length. Which samples it goes through is therefore chosen as in
essentially non-oscillatory interpolation (Harten et al., J. Comput. Phys. 71, 1987), among the
windows of neighbors that hold an interval: the one that a further sample changes least.

The polynomials are Newton's divided differences; a sample with a velocity is a double node (Burden
& Faires, Numerical Analysis, section 3.4). They are Lagrange's and Hermite's, written otherwise.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.environment.constants import EARTH_MU


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


#: A window around an interval whose error is less [m] is not compared with others.
_EXACT = 1e-3
#: It has to be as many times as good as the one around an instant to take its place.
_BETTER = 0.5
_BLOCK = 50_000  # polynomials at once; bounds memory


@dataclass(frozen=True, eq=False)
class Arc:
    """Two or more samples at increasing `times` [s], shape (n,): `position` [m] and, if known,
    `velocity` [m/s], shape (n, 3), about the Earth; each polynomial goes through `count` <= n."""

    times: Floats
    position: Floats
    velocity: Floats | None
    count: int

    def at(self, at: Floats) -> tuple[Floats, Floats]:
        """Position [m] and its slope [m/s], shape (k, 3), at times of shape (k,)."""
        last = len(self.times) - 2
        interval = np.clip(np.searchsorted(self.times, at, side="right") - 1, 0, last)
        around, (chosen, _) = nearest(self.times, at, self.count)[:, 0], self._windows
        first = np.where(chosen[interval] < 0, around, chosen[interval])
        return self._through(first, self.count, at)

    @property
    def error(self) -> Floats:
        """What the error in the middle of each interval is about [m], shape (n - 1,)."""
        return self._windows[1]

    def missed(self, suspicious: float) -> Floats:
        """How far each sample is from what those around it give [m], shape (n,).

        Of those missed by more than `suspicious`, it is from what any window that holds both its
        neighbors gives. The first and the last, between no others, count as met.
        """
        n, count = len(self.times), min(self.count, len(self.times) - 1)
        own = np.arange(1, n - 1)
        missed = np.zeros(n)
        missed[own] = self._apart(own, others(n, count)[own])
        (far,) = np.nonzero(missed > suspicious)
        for shift in range(1, count):
            rows = np.clip(far - shift, 0, n - 1 - count)[:, None] + np.arange(count)
            rows += rows >= far[:, None]
            missed[far] = np.minimum(missed[far], self._apart(far, rows))
        return missed

    @cached_property
    def _windows(self) -> tuple[Ints, Floats]:
        """First sample of each interval's window, -1 for those around an instant; its error."""
        middle = 0.5 * (self.times[1:] + self.times[:-1])
        error = self._error(nearest(self.times, middle, self.count)[:, 0], middle)
        chosen = np.full(len(middle), -1)
        (doubtful,) = np.nonzero(error > _EXACT)
        limit = _BETTER * error
        for shift in range(self.count - 1):
            first = np.clip(doubtful - shift, 0, len(self.times) - self.count)
            found = self._error(first, middle[doubtful])
            better = found < np.minimum(error, limit)[doubtful]
            chosen[doubtful[better]], error[doubtful[better]] = first[better], found[better]
        return chosen, error

    def _error(self, first: Ints, at: Floats) -> Floats:
        """By how much the nearer of two further samples moves what windows give [m], shape (k,)."""
        n, count = len(self.times), self.count
        if n == count:
            return self._expected_error(at)
        given, _ = self._through(first, count, at)
        moved = [
            np.where(
                (start >= 0) & (start + count < n),
                _length(self._through(np.clip(start, 0, n - count - 1), count + 1, at)[0] - given),
                np.inf,
            )
            for start in (first - 1, first)
        ]
        return np.asarray(np.minimum(*moved))

    def _expected_error(self, at: Floats) -> Floats:
        """Of polynomials through all samples, as on a circle: their next term, see `interpolate`.

        Derivatives of the position are its radius times powers of the angular rate there.
        """
        radius = float(_length(self.position).min())
        rate = math.sqrt(EARTH_MU / radius**3)
        factors = np.repeat(rate * (at[:, None] - self.times), 1 + (self.velocity is not None), 1)
        return np.asarray(radius * np.abs(np.prod(factors / np.arange(1, 1 + factors.shape[1]), 1)))

    def _apart(self, own: Ints, rows: Ints) -> Floats:
        """From samples to what polynomials through others give there [m], shape (k,)."""
        given, _ = interpolate(self.times, self.position, self.velocity, rows, self.times[own])
        return _length(given - self.position[own])

    def _through(self, first: Ints, count: int, at: Floats) -> tuple[Floats, Floats]:
        blocks = range(0, max(1, len(at)), _BLOCK)
        found = [
            interpolate(
                self.times,
                self.position,
                self.velocity,
                first[k : k + _BLOCK, None] + np.arange(count),
                at[k : k + _BLOCK],
            )
            for k in blocks
        ]
        value, slope = zip(*found, strict=True)
        return np.concatenate(value), np.concatenate(slope)


def _length(vectors: Floats) -> Floats:
    return np.asarray(np.linalg.norm(vectors, axis=-1))
