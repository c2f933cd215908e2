"""Checks of the lengths of measured vectors, which need no attitude: outliers and normalized
vectors.
"""

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
#: Smallest number of vectors from which a sensor is called normalized.
_MIN_VECTORS = 10
#: Ratio of 1-sigma to the median absolute deviation of a normal distribution.
_SIGMA_PER_MAD = 1.4826


def find_outlying_lengths(batch: Batch) -> Bools:
    """Return a boolean mask of shape (s, N) that marks the readings with an outlying vector length.

    The length relative to the modeled length is compared with the median of the same sensor,
    because a bias changes all lengths equally, or by less than the scatter of the lengths. Only
    readings of one 3-vector are checked.

    Parameters
    ----------
    batch : Batch
        Batch of N samples of s sensors.
    """
    result = np.zeros((len(batch.readings), len(batch.times)), dtype=bool)
    for index, rows in enumerate(batch.readings):
        has_reading = np.isfinite(rows[:, 0, 0])
        if rows.shape[1:] != (1, 3) or not has_reading.any():
            continue
        deviation = _compute_length(rows[has_reading, 0]) - _compute_length(
            batch.vectors[has_reading, index]
        )
        deviation -= np.median(deviation)
        scatter = max(
            _SIGMA_PER_MAD * float(np.median(np.abs(deviation))), float(batch.noise[index].max())
        )
        result[index, has_reading] = np.abs(deviation) > _OUTLIER_FACTOR * scatter
    return result


def validate_vector_lengths(batch: Batch) -> None:
    """Raise ValueError if a Sun sensor reports unit vectors but is declared with three-axis noise.

    Noise along all three axes would change the lengths of the vectors.

    Parameters
    ----------
    batch : Batch

    Raises
    ------
    ValueError
        With the sensor kind to declare instead.
    """
    for sensor, rows in zip(batch.suite.sensors, batch.readings, strict=True):
        has_reading = np.isfinite(rows[:, 0, 0])
        if (
            not isinstance(sensor, SunSensor)
            or sensor.has_unit_length
            or has_reading.sum() < _MIN_VECTORS
        ):
            continue
        length, noise = _compute_length(rows[has_reading, 0]), min(sensor.noise_sigmas())
        scatter = float(np.median(np.abs(length - np.median(length))))
        if scatter < _MAX_NORMALIZED_SCATTER * noise:
            raise ValueError(
                f"{sensor.name}: the lengths of the vectors scatter by {scatter:.2g}: expected "
                f"{noise:.2g}, the noise along each axis. The vectors are normalized. Use kind = "
                f'"{TwoAxisSunSensor.kind}" instead of "{sensor.kind}"'
            )


def _compute_length(vectors: Floats) -> Floats:
    with np.errstate(over="ignore"):
        length: Floats = np.linalg.norm(vectors, axis=1)
    return length
