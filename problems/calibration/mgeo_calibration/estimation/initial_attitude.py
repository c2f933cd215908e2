"""Initial attitude of a batch by Wahba's problem over an interval of samples."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from mgeo_attitude._typing import Bools, Floats, Ints
from mgeo_attitude.sensors.error_models import apply_bias_sensitivities
from mgeo_attitude.sensors.photodiode import Photodiode
from mgeo_attitude.sensors.suite import Suite
from scipy.spatial.transform import Rotation

from mgeo_calibration.estimation.batch import Batch
from mgeo_calibration.estimation.kernels import load_compiled_module
from mgeo_calibration.estimation.kinematics import compute_rates_and_rotations

#: Lengths of intervals to try, in samples. The first sufficient interval is used.
INTERVAL_LENGTHS = (10, 30, 100, 300, 1000, 3000)
#: Smallest second eigenvalue of the mean dyad of the directions; 20° between two directions.
MIN_SPREAD = 0.03
#: Smallest eigenvalue of Σ n nᵀ over the normals of lit faces; three orthogonal faces give 1.
_MIN_NORMAL_SPREAD = 0.05


@dataclass(frozen=True, eq=False)
class Directions:
    """Pairs of unit vectors in the body frame and in GCRS, weighted for Wahba's problem.

    Attributes
    ----------
    samples : array of int, shape (m,)
        Sample index of each vector.
    sensors : array of int, shape (m,)
        Sensor index of each vector.
    weights : array, shape (m,)
        Weights. The weights of each sensor add up to the same total, whatever its number of
        readings.
    body : array, shape (m, 3)
        Observed directions in the body frame of sample 0.
    inertial : array, shape (m, 3)
        Directions in GCRS.
    """

    samples: Ints
    sensors: Ints
    weights: Floats
    body: Floats
    inertial: Floats


def estimate_initial_attitude(batch: Batch, states: Floats) -> tuple[Floats, slice]:
    """Estimate the attitude at all samples by solving Wahba's problem in a short interval and
    integrating the gyro rates.

    The interval is the shortest in which the observed directions are far enough apart. The attitude
    is also propagated across gyro breaks.

    Parameters
    ----------
    batch : Batch
        Batch of N samples.
    states : array, shape (N, n_states)
        States with the gyro and sensor errors to correct.

    Returns
    -------
    attitude : array, shape (N, 3, 3)
        Rotation matrices from body to GCRS.
    interval : slice
        Samples of which Wahba's problem used the directions.

    Raises
    ------
    ValueError
        If no interval has vectors that are far enough apart.
    """
    rotations = accumulate_rotations(batch, states)
    directions = collect_directions(batch, rotations, states)
    interval = find_interval(directions, len(batch.times))
    is_used = (directions.samples >= interval.start) & (directions.samples < interval.stop)
    rotation, _ = solve_wahba(directions, is_used)
    return rotation @ rotations, interval


def count_propagated_samples(batch: Batch, bias_sigma: Floats, max_angle: float) -> int:
    """Return the number of samples over which the attitude can be propagated before the unknown
    gyro bias rotates it by `max_angle`.

    The number is at most the number of samples of the batch.

    Parameters
    ----------
    batch : Batch
    bias_sigma : array, shape (3,)
        1-sigma of the bias [rad/s].
    max_angle : float
        Largest rotation [rad].
    """
    return int(
        min(len(batch.times), max_angle / (np.linalg.norm(bias_sigma) * np.median(batch.durations)))
    )


def accumulate_rotations(batch: Batch, states: Floats) -> Floats:
    """Integrate the gyro rates into rotation matrices from the body frame at each sample to the
    body frame at the first sample.

    Parameters
    ----------
    batch : Batch
        Batch of N samples.
    states : array, shape (N, n_states)
        States with the gyro errors to correct.

    Returns
    -------
    array, shape (N, 3, 3)
    """
    _, step_rotations = compute_rates_and_rotations(batch, states)
    R = np.empty((len(step_rotations) + 1, 3, 3))
    load_compiled_module("kinematics").accumulate_rotations(np.ascontiguousarray(step_rotations), R)
    return R


def collect_directions(batch: Batch, rotations: Floats, states: Floats) -> Directions:
    """Collect the unit vectors that all sensors observe, in the body frame of the first sample and
    in GCRS.

    A star tracker contributes the three axes of GCRS. All photodiodes together contribute one Sun
    direction.

    Parameters
    ----------
    batch : Batch
        Batch of N samples.
    rotations : array, shape (N, 3, 3)
        Result of `accumulate_rotations`.
    states : array, shape (N, n_states)
        States with the sensor biases to correct.

    Returns
    -------
    Directions
    """
    samples, sensors, weights, body, inertial = [], [], [], [], []
    suns = compute_sun_directions(batch.suite, batch.readings, states)
    for index, rows in enumerate(batch.readings):
        if rows.shape[2] == 1:  # The first photodiode carries the common Sun direction.
            rows, suns = suns[:, None], np.full_like(suns, np.nan)
        k = np.flatnonzero(np.isfinite(rows[:, 0, 0]))
        bias_index = batch.suite.get_first_indices(batch.suite.sensors[index]).get("bias")
        if rows.shape[1] == 1 and bias_index is not None:
            sensor = batch.suite.sensors[index]
            state_values = {
                state: states[:, first : first + 3]
                for state, first in batch.suite.get_first_indices(sensor).items()
            }
            apply_bias_sensitivities(
                sensor.bias_sensitivities,
                state_values,
                batch.select_channel_values(sensor, slice(None)),
            )
            rows = rows - state_values["bias"][:, None]
        for i in range(rows.shape[1]):
            references = (
                batch.vectors[k, index]
                if rows.shape[1] == 1
                else np.tile(np.eye(3)[i], (len(k), 1))
            )
            lengths = [np.linalg.norm(v, axis=1) for v in (rows[k, i], references)]
            is_nonzero = (lengths[0] > 0.0) & (lengths[1] > 0.0)
            rotated = np.einsum("nij,nj->ni", rotations[k], rows[k, i])
            samples.append(k[is_nonzero])
            sensors.append(np.full(is_nonzero.sum(), index))
            weights.append(np.full(is_nonzero.sum(), 1.0 / max(len(k), 1)))
            body.append(rotated[is_nonzero] / lengths[0][is_nonzero, None])
            inertial.append(references[is_nonzero] / lengths[1][is_nonzero, None])
    return Directions(*map(np.concatenate, (samples, sensors, weights, body, inertial)))


def compute_sun_directions(suite: Suite, readings: Sequence[Floats], states: Floats) -> Floats:
    """Estimate the Sun direction in the body frame at each sample from all photodiodes, as an array
    of shape (N, 3).

    The solution needs at least three lit photodiodes with normals that are well apart; other
    samples are NaN.

    Parameters
    ----------
    suite : Suite
    readings : sequence of arrays, shape (N, k, 3)
        Readings of each sensor of the suite.
    states : array, shape (N, n_states)
        States with the errors to correct.
    """
    A, b = np.zeros((len(states), 3, 3)), np.zeros((len(states), 3))
    for sensor, rows in zip(suite.sensors, readings, strict=True):
        if isinstance(sensor, Photodiode):
            first = suite.get_first_indices(sensor)["sensitivity"]
            normals = sensor.axes[2] + states[:, first : first + 3] @ sensor.axes
            has_reading = np.isfinite(rows[:, 0, 0])
            A[has_reading] += normals[has_reading, :, None] * normals[has_reading, None]
            b[has_reading] += normals[has_reading] * rows[has_reading, 0]
    result = np.full(b.shape, np.nan)
    is_solvable = np.linalg.eigvalsh(A)[:, 0] > _MIN_NORMAL_SPREAD
    result[is_solvable] = np.linalg.solve(A[is_solvable], b[is_solvable, :, None])[..., 0]
    return result


def find_interval(directions: Directions, n_samples: int) -> slice:
    """Find the shortest interval in which the observed directions are far enough apart to determine
    an attitude.

    The second eigenvalue of the mean dyad of the directions is compared with `MIN_SPREAD`. Interval
    lengths come from `INTERVAL_LENGTHS`. Among intervals of equal length, the first is returned.

    Parameters
    ----------
    directions : Directions
    n_samples : int
        Number of samples.

    Raises
    ------
    ValueError
        If the directions are too close together in all intervals.
    """
    dyads, weights = np.zeros((n_samples + 1, 3, 3)), np.zeros(n_samples + 1)
    np.add.at(
        dyads,
        directions.samples + 1,
        directions.weights[:, None, None] * directions.body[:, :, None] * directions.body[:, None],
    )
    np.add.at(weights, directions.samples + 1, directions.weights)
    dyads, weights = np.cumsum(dyads, axis=0), np.cumsum(weights)
    best = 0.0
    for length in (min(length, n_samples) for length in INTERVAL_LENGTHS):
        first = np.arange(0, n_samples - length + 1, max(1, length // 4))
        total = weights[first + length] - weights[first]
        spread = np.linalg.eigvalsh(dyads[first + length] - dyads[first])[:, 1]
        spread = np.divide(spread, total, out=np.zeros_like(spread), where=total > 0.0)
        if (spread >= MIN_SPREAD).any():
            start = int(first[np.argmax(spread >= MIN_SPREAD)])
            return slice(start, start + length)
        best = max(best, float(spread.max()))
    angle = np.degrees(np.arcsin(min(1.0, 2.0 * np.sqrt(best))))
    raise ValueError(
        f"the observed vectors are nowhere more than {angle:.2g} deg apart and do not determine "
        "an attitude"
    )


def solve_wahba(directions: Directions, is_used: Bools) -> tuple[Floats, float]:
    """Solve Wahba's problem for the selected directions. Return the rotation from body to GCRS and
    the median squared residual.

    Outliers of each sensor are excluded in two further solutions.

    Parameters
    ----------
    directions : Directions
    is_used : array of bool, shape (m,)
        Directions to use.

    Returns
    -------
    rotation : array, shape (3, 3)
        Rotation matrix from the body frame of sample 0 to GCRS.
    square : float
        Median squared residual of the directions.
    """
    inertial, body = directions.inertial[is_used], directions.body[is_used]
    sensor, weight = directions.sensors[is_used], directions.weights[is_used]
    is_inlier = np.ones(len(body), dtype=bool)
    for _ in range(3):
        rotation, _ = Rotation.align_vectors(
            inertial[is_inlier], body[is_inlier], weight[is_inlier]
        )
        square = ((inertial - rotation.apply(body)) ** 2).sum(axis=1)
        # The threshold is relative to the scatter: biases may exceed the declared noise.
        for index in np.unique(sensor):
            is_of_sensor = sensor == index
            is_inlier[is_of_sensor] = (
                square[is_of_sensor] <= 9.0 * np.median(square[is_of_sensor]) + 1e-12
            )
    return rotation.as_matrix(), float(np.median(square))
