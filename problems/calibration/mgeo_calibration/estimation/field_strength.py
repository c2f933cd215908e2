"""A magnetometer by the strength of the field alone, whatever its attitude.

TWOSTEP (R. Alonso and M. D. Shuster, Complete Linear Attitude-Independent Magnetometer Calibration,
Journal of the Astronautical Sciences 50 (2002) 477-490): a linear estimate from differences to the
mean, in which squares of the unknowns drop out, then Gauss-Newton on all of them. A rotation of the
magnetometer does not change a length: its misalignment is not to be found.

A magnetometer reports m = (I + diag k + N) B + b, with the elements yz, zx and xy of the symmetric
N. With u = (I + diag k + N)⁻¹ (m - b), |u|² - |B|² is zero but for noise. Unknowns are b, k and N,
nine numbers in this order.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from mgeo_attitude._typing import Bools, Floats
from mgeo_attitude.sensors.vector_sensors import Magnetometer

from mgeo_calibration.estimation.batch import Batch
from mgeo_calibration.estimation.belief import Belief
from mgeo_calibration.estimation.lengths import implausible

#: Fewer readings say nothing of nine unknowns.
FEWEST = 20
#: Blocks of a magnetometer's states that lengths depend on, in the order of the unknowns.
BLOCKS = ("bias", "scale_factor", "nonorthogonality")
_LARGE = 0.1  # share of the field's strength from which on a bias spoils directions
_MOST = 3000  # readings that are enough for a start
_ITERATIONS = 30
_LAST = 1e-6  # step, in 1-sigmas, that is the last
_PAIRS = ((1, 2), (2, 0), (0, 1))  # of the elements of N


@dataclass(frozen=True, eq=False)
class FieldStrengthFit:
    """What lengths say.

    Attributes
    ----------
    values : array, shape (9,)
        b, in the unit of the field, then k and N [-].
    covariance : array, shape (9, 9)
        Zero of what is not estimated.
    residuals : array, shape (n,)
        Of every reading, standard normal if the noise is as given.
    """

    values: Floats
    covariance: Floats
    residuals: Floats


def fit_field_strength(
    measured: Floats, strength: Floats, sigma: Floats, mean: Floats, prior: Floats
) -> FieldStrengthFit:
    """The most probable b, k and N of a magnetometer.

    Parameters
    ----------
    measured : array, shape (n, 3)
    strength : array, shape (n,)
        Of the field, where and when the magnetometer measured, in the same unit.
    sigma : array, shape (3,)
        Noise per axis, 1-sigma.
    mean, prior : arrays, shape (9,)
        What is believed of the unknowns, and its 1-sigmas; what has none, zero, is not estimated.

    Raises
    ------
    ValueError
        For fewer than `FEWEST` readings, or an estimate that does not settle.
    """
    if len(measured) < FEWEST:
        raise ValueError(f"{len(measured)} readings: expected {FEWEST} or more")
    free = prior > 0.0
    weight = np.where(free, 1.0 / np.where(free, prior, 1.0), 0.0)
    starts = [mean, np.where(free, _linear(measured, strength, sigma, free), mean)]

    def equations(values: Floats, spread: Floats) -> tuple[Floats, Floats]:
        z, slopes = _residuals(values, measured, strength, sigma)
        r = np.concatenate([z / spread, weight * (values - mean)])
        return r, np.vstack([slopes / spread[:, None], np.diag(weight)])[:, free]

    def cost(values: Floats, spread: Floats) -> float:
        r, _ = equations(values, spread)
        total = float(r @ r)
        return total if np.isfinite(total) else np.inf

    values = min(starts, key=lambda start: cost(start, _spread(start, measured, sigma)))
    for _ in range(_ITERATIONS):
        spread = _spread(values, measured, sigma)  # weights, which do not change within a step
        r, J = equations(values, spread)
        found, *_ = np.linalg.lstsq(J, -r, rcond=None)
        step = np.zeros(9)
        step[free] = found
        while cost(values + step, spread) > (1.0 + 1e-9) * float(r @ r):
            step *= 0.5
        values = values + step
        if np.linalg.norm(J @ step[free]) < _LAST:
            break
    else:
        raise ValueError("the strength of the field does not say bias and scale: no end of steps")
    r, J = equations(values, _spread(values, measured, sigma))
    covariance = np.zeros((9, 9))
    covariance[np.ix_(free, free)] = np.linalg.inv(J.T @ J)
    return FieldStrengthFit(values, covariance, r[: len(measured)])


def by_strength(
    batch: Batch, index: int, belief: Belief, most: int | None = None
) -> FieldStrengthFit:
    """Of a magnetometer of a batch, in the filter's units; raises as `fit_field_strength`.

    What else varies in the field counts as noise. Readings whose length stands apart are left out.

    Parameters
    ----------
    index : int
        Of the sensor.
    most : int, optional
        Readings to take, evenly.
    """
    suite, sensor = batch.suite, batch.suite.sensors[index]
    places = suite.places(sensor)
    mean, prior = np.zeros(9), np.zeros(9)
    for number, block in enumerate(BLOCKS):
        if block in places:
            own = slice(places[block], places[block] + 3)
            mean[3 * number : 3 * number + 3] = belief.states[own]
            prior[3 * number : 3 * number + 3] = belief.sigma[own]
    varying = places.get("field_error")
    more = 0.0 if varying is None else belief.sigma[varying : varying + 3]
    seen = np.flatnonzero(np.isfinite(batch.sensors[index][:, 0, 0]) & ~implausible(batch)[index])
    seen = seen[:: max(1, len(seen) // most) if most else 1]
    return fit_field_strength(
        batch.sensors[index][seen, 0],
        np.linalg.norm(batch.vectors[seen, index], axis=1),
        np.hypot(batch.noise[index], more),
        mean,
        prior,
    )


def start_states(batch: Batch, belief: Belief) -> Floats:
    """States to begin with, shape (n_states,): what is believed, but for magnetometers whose bias
    may be so large that directions with it in them lead astray; theirs is that of the strength."""
    states = belief.states.copy()
    for index, sensor in enumerate(batch.suite.sensors):
        if not isinstance(sensor, Magnetometer):
            continue
        places = batch.suite.places(sensor)
        strength = float(np.median(np.linalg.norm(batch.vectors[:, index], axis=1)))
        if belief.sigma[places["bias"]] < _LARGE * strength:
            continue
        try:
            found = by_strength(batch, index, belief, _MOST)
        except ValueError:
            continue  # what is believed is all there is
        for number, block in enumerate(BLOCKS):
            if block in places:
                first = places[block]
                states[first : first + 3] = found.values[3 * number : 3 * number + 3]
    return states


def response(values: Floats) -> Floats:
    """I + diag k + N, shape (3, 3)."""
    K = np.diag(1.0 + values[3:6])
    for value, (i, j) in zip(values[6:], _PAIRS, strict=True):
        K[i, j] = K[j, i] = value
    return K


def _residuals(
    values: Floats, measured: Floats, strength: Floats, sigma: Floats
) -> tuple[Floats, Floats]:
    """|u|² - |B|² without what noise adds in the mean, and its derivatives, shapes (n,), (n, 9)."""
    W = np.linalg.inv(response(values))
    u = (measured - values[:3]) @ W
    Wu = u @ W
    z = (u * u).sum(axis=1) - strength**2 - np.trace((W * sigma**2) @ W)
    shear = [Wu[:, i] * u[:, j] + Wu[:, j] * u[:, i] for i, j in _PAIRS]
    return z, -2.0 * np.column_stack([Wu, Wu * u, *shear])


def _spread(values: Floats, measured: Floats, sigma: Floats) -> Floats:
    """1-sigma of those residuals, shape (n,): noise w adds 2 uᵀ W w + |W w|², W = (I + ...)⁻¹."""
    W = np.linalg.inv(response(values))
    Wu = (measured - values[:3]) @ W @ W
    noise = (W * sigma**2) @ W
    spread: Floats = np.sqrt(4.0 * ((Wu * sigma) ** 2).sum(axis=1) + 2.0 * (noise**2).sum())
    return spread


def _linear(measured: Floats, strength: Floats, sigma: Floats, free: Bools) -> Floats:
    """The first step: |m|² - |B|² = 2 mᵀ d - mᵀ E m + a constant, with I + E = (I + diag k + N)⁻²
    and d = (I + E) b, by differences to the mean."""
    scale = float(np.median(strength))
    m = measured / scale
    z = (m * m).sum(axis=1) - (strength / scale) ** 2
    pairs = [-2.0 * m[:, i] * m[:, j] for i, j in _PAIRS]
    A = np.column_stack([2.0 * m, -m * m, *pairs])
    estimated = free.copy()
    estimated[3:] = free[3:].any()
    A, z = A - A.mean(axis=0), z - z.mean()
    found = np.zeros(9)
    found[estimated], *_ = np.linalg.lstsq(A[:, estimated], z, rcond=None)
    square = response(found)
    sizes, axes = np.linalg.eigh(square)
    if sizes.min() <= 0.0:  # no ellipsoid
        found[3:], square = 0.0, np.eye(3)
        sizes, axes = np.linalg.eigh(square)
    K = (axes / np.sqrt(sizes)) @ axes.T
    bias = scale * np.linalg.solve(square, found[:3])
    return np.concatenate([bias, np.diag(K) - 1.0, [K[i, j] for i, j in _PAIRS]])
