"""A first attitude from vectors alone: Wahba's problem over a stretch of samples."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from mgeo_attitude._typing import Bools, Floats, Ints
from mgeo_attitude.sensors.errors import influenced
from mgeo_attitude.sensors.photodiode import Photodiode
from mgeo_attitude.sensors.suite import Suite
from scipy.spatial.transform import Rotation

from mgeo_calibration.estimation.batch import Batch
from mgeo_calibration.estimation.kernels import load
from mgeo_calibration.estimation.kinematics import turns

#: Lengths of stretches to look at, in samples; the first that will do is taken.
LENGTHS = (10, 30, 100, 300, 1000, 3000)
#: Directions have to be this far apart: the second eigenvalue of their mean dyad; 20° between two.
SPREAD = 0.03
#: Smallest eigenvalue of Σ n nᵀ over normals of lit faces: it is 1 of three at right angles.
_APART = 0.05


@dataclass(frozen=True, eq=False)
class Directions:
    """Unit vectors that were seen, m of them, in the body axes of sample 0, and what they are.

    Attributes
    ----------
    samples : array of int, shape (m,)
    sensor : array of int, shape (m,)
    weight : array, shape (m,)
        All sensors together weigh the same, how often each may have reported.
    body, inertial : arrays, shape (m, 3)
    """

    samples: Ints
    sensor: Ints
    weight: Floats
    body: Floats
    inertial: Floats


def first_attitude(batch: Batch, states: Floats) -> tuple[Floats, slice]:
    """Attitudes, body to GCRS, shape (N, 3, 3), by Wahba's problem; and where it was solved.

    Rates of the gyro carry the attitude between samples; `breaks` count for nothing.

    Parameters
    ----------
    states : array, shape (N, n_states)

    Raises
    ------
    ValueError
        If nowhere vectors are far enough apart.
    """
    relative = accumulated(batch, states)
    seen = directions(batch, relative, states)
    where = stretch(seen, len(batch.times))
    chosen = (seen.samples >= where.start) & (seen.samples < where.stop)
    rotation, _ = wahba(seen, chosen)
    return rotation @ relative, where


def carried_for(batch: Batch, sigma: Floats, angle: float) -> int:
    """Samples over which the gyro's bias turns the attitude by an angle [rad], 1-sigma.

    Parameters
    ----------
    sigma : array, shape (3,)
        Of the bias [rad/s].
    """
    return int(min(len(batch.times), angle / (np.linalg.norm(sigma) * np.median(batch.durations))))


def accumulated(batch: Batch, states: Floats) -> Floats:
    """Rotations from the body axes of every sample to those of the first, shape (N, 3, 3)."""
    _, turn = turns(batch, states)
    R = np.empty((len(turn) + 1, 3, 3))
    load("kinematics").accumulated(np.ascontiguousarray(turn), R)
    return R


def directions(batch: Batch, relative: Floats, states: Floats) -> Directions:
    """All vectors of all sensors; those of a sensor of several are the axes of GCRS.

    Photodiodes give one together.

    Parameters
    ----------
    relative : array, shape (N, 3, 3)
        See `accumulated`.
    states : array, shape (N, n_states)
        Whose biases are taken out of vectors.
    """
    samples, sensors, weights, body, inertial = [], [], [], [], []
    suns = sun_directions(batch.suite, batch.sensors, states)
    for index, rows in enumerate(batch.sensors):
        if rows.shape[2] == 1:  # the first of all photodiodes stands for them
            rows, suns = suns[:, None], np.full_like(suns, np.nan)
        k = np.flatnonzero(np.isfinite(rows[:, 0, 0]))
        place = batch.suite.places(batch.suite.sensors[index]).get("bias")
        if rows.shape[1] == 1 and place is not None:
            sensor = batch.suite.sensors[index]
            own = {
                state: states[:, first : first + 3]
                for state, first in batch.suite.places(sensor).items()
            }
            influenced(sensor.influences, own, batch.follows(sensor, slice(None)))
            rows = rows - own["bias"][:, None]
        for i in range(rows.shape[1]):
            known = (
                batch.vectors[k, index]
                if rows.shape[1] == 1
                else np.tile(np.eye(3)[i], (len(k), 1))
            )
            lengths = [np.linalg.norm(v, axis=1) for v in (rows[k, i], known)]
            some = (lengths[0] > 0.0) & (lengths[1] > 0.0)
            turned = np.einsum("nij,nj->ni", relative[k], rows[k, i])
            samples.append(k[some])
            sensors.append(np.full(some.sum(), index))
            weights.append(np.full(some.sum(), 1.0 / max(len(k), 1)))
            body.append(turned[some] / lengths[0][some, None])
            inertial.append(known[some] / lengths[1][some, None])
    return Directions(*map(np.concatenate, (samples, sensors, weights, body, inertial)))


def sun_directions(suite: Suite, readings: Sequence[Floats], states: Floats) -> Floats:
    """Where all photodiodes together see the Sun, body axes, shape (N, 3), NaN where they do not.

    By least squares over those that are lit, of which three or more have to look well apart.

    Parameters
    ----------
    readings : sequence of array, shape (N, k, 3)
        Of each sensor of the suite.
    states : array, shape (N, n_states)
        Whose errors are taken out.
    """
    A, b = np.zeros((len(states), 3, 3)), np.zeros((len(states), 3))
    for sensor, rows in zip(suite.sensors, readings, strict=True):
        if isinstance(sensor, Photodiode):
            first = suite.places(sensor)["sensitivity"]
            normals = sensor.axes[2] + states[:, first : first + 3] @ sensor.axes
            seen = np.isfinite(rows[:, 0, 0])
            A[seen] += normals[seen, :, None] * normals[seen, None]
            b[seen] += normals[seen] * rows[seen, 0]
    found = np.full(b.shape, np.nan)
    apart = np.linalg.eigvalsh(A)[:, 0] > _APART
    found[apart] = np.linalg.solve(A[apart], b[apart, :, None])[..., 0]
    return found


def stretch(seen: Directions, n: int) -> slice:
    """The first of the shortest stretches of n samples in which directions are far apart.

    Raises
    ------
    ValueError
        If there is none.
    """
    dyads, weights = np.zeros((n + 1, 3, 3)), np.zeros(n + 1)
    np.add.at(
        dyads,
        seen.samples + 1,
        seen.weight[:, None, None] * seen.body[:, :, None] * seen.body[:, None],
    )
    np.add.at(weights, seen.samples + 1, seen.weight)
    dyads, weights = np.cumsum(dyads, axis=0), np.cumsum(weights)
    best = 0.0
    for length in (min(length, n) for length in LENGTHS):
        first = np.arange(0, n - length + 1, max(1, length // 4))
        total = weights[first + length] - weights[first]
        spread = np.linalg.eigvalsh(dyads[first + length] - dyads[first])[:, 1]
        spread = np.divide(spread, total, out=np.zeros_like(spread), where=total > 0.0)
        if (spread >= SPREAD).any():
            start = int(first[np.argmax(spread >= SPREAD)])
            return slice(start, start + length)
        best = max(best, float(spread.max()))
    angle = np.degrees(np.arcsin(min(1.0, 2.0 * np.sqrt(best))))
    raise ValueError(
        f"the vectors that were seen are nowhere more than {angle:.2g} deg apart: no attitude "
        "follows from them"
    )


def wahba(seen: Directions, chosen: Bools) -> tuple[Floats, float]:
    """Rotation from the body axes of sample 0 to GCRS, and the median square residual.

    It is solved again without the worst directions of each sensor: one that is wrong turns
    everything.
    """
    inertial, body = seen.inertial[chosen], seen.body[chosen]
    sensor, weight = seen.sensor[chosen], seen.weight[chosen]
    kept = np.ones(len(body), dtype=bool)
    for _ in range(3):
        rotation, _ = Rotation.align_vectors(inertial[kept], body[kept], weight[kept])
        square = ((inertial - rotation.apply(body)) ** 2).sum(axis=1)
        for one in np.unique(sensor):  # by its own scatter: biases may be larger than noise
            own = sensor == one
            kept[own] = square[own] <= 9.0 * np.median(square[own]) + 1e-12
    return rotation.as_matrix(), float(np.median(square))
