"""Checks of vector lengths, which need no attitude: outliers and normalized vectors."""

from __future__ import annotations

import numpy as np
from mgeo_attitude._typing import Bools, Floats
from mgeo_attitude.sensors.direction_sensors import TwoAxisSunSensor
from mgeo_attitude.sensors.vector_sensors import SunSensor

from mgeo_calibration.estimation.batch import Batch

#: Smallest deviation of an outlier's length, in units of the scatter of its sensor.
_OUTLIER_FACTOR = 20.0
#: Largest scatter of the lengths of normalized vectors, relative to the declared noise.
_MAX_NORMALIZED_SCATTER = 0.05
_MIN_VECTORS = 10  # smallest number of vectors for a decision
_SIGMA_PER_MAD = (
    1.4826  # ratio of 1-sigma to the median absolute deviation of a normal distribution
)


def find_outlying_lengths(batch: Batch) -> Bools:
    """Return a mask of vectors with outlying lengths, shape (s, N).

    Lengths are compared with the median of their sensor. A bias changes all lengths alike, or less
    than they scatter.
    """
    result = np.zeros((len(batch.readings), len(batch.times)), dtype=bool)
    for index, rows in enumerate(batch.readings):
        seen = np.isfinite(rows[:, 0, 0])
        if rows.shape[1:] != (1, 3) or not seen.any():
            continue
        off = _compute_length(rows[seen, 0]) - _compute_length(batch.vectors[seen, index])
        off -= np.median(off)
        scatter = max(
            _SIGMA_PER_MAD * float(np.median(np.abs(off))), float(batch.noise[index].max())
        )
        result[index, seen] = np.abs(off) > _OUTLIER_FACTOR * scatter
    return result


def validate_vector_lengths(batch: Batch) -> None:
    """Raise ValueError if a Sun sensor reports unit vectors instead of three noisy components.

    Raises
    ------
    ValueError
        With the sensor kind to use instead.
    """
    for sensor, rows in zip(batch.suite.sensors, batch.readings, strict=True):
        seen = np.isfinite(rows[:, 0, 0])
        if not isinstance(sensor, SunSensor) or sensor.has_unit_length or seen.sum() < _MIN_VECTORS:
            continue
        length, noise = _compute_length(rows[seen, 0]), min(sensor.noise_sigmas())
        scatter = float(np.median(np.abs(length - np.median(length))))
        if scatter < _MAX_NORMALIZED_SCATTER * noise:
            raise ValueError(
                f"{sensor.name}: the lengths of its vectors scatter by {scatter:.2g}, where noise "
                f"of {noise:.2g} along each axis is expected: these are directions, of two numbers "
                f'each. Expected kind = "{TwoAxisSunSensor.kind}", not "{sensor.kind}"'
            )


def _compute_length(vectors: Floats) -> Floats:
    with np.errstate(over="ignore"):
        length: Floats = np.linalg.norm(vectors, axis=1)
    return length
