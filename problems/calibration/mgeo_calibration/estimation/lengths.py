"""Lengths of vectors: outliers that need no attitude, and directions where vectors are expected."""

from __future__ import annotations

import numpy as np
from mgeo_attitude._typing import Bools, Floats
from mgeo_attitude.sensors.direction_sensors import TwoAxisSunSensor
from mgeo_attitude.sensors.vector_sensors import SunSensor

from mgeo_calibration.estimation.batch import Batch

#: Times the scatter of its sensor by which a vector is too long or too short.
_FAR = 20.0
#: Lengths that scatter by less than this share of the noise are those of normalized vectors.
_NORMALIZED = 0.05
_FEWEST = 10  # vectors, or samples, that can tell
_NORMAL = 1.4826  # 1-sigma of normal numbers over their median absolute deviation


def implausible(batch: Batch) -> Bools:
    """Vectors whose lengths stand apart from all others of their sensor, shape (s, N).

    Lengths need no attitude. A bias changes them less than they scatter, or all of them alike.
    """
    found = np.zeros((len(batch.sensors), len(batch.times)), dtype=bool)
    for index, rows in enumerate(batch.sensors):
        seen = np.isfinite(rows[:, 0, 0])
        if rows.shape[1:] != (1, 3) or not seen.any():
            continue
        off = _length(rows[seen, 0]) - _length(batch.vectors[seen, index])
        off -= np.median(off)
        scatter = max(_NORMAL * float(np.median(np.abs(off))), float(batch.noise[index].max()))
        found[index, seen] = np.abs(off) > _FAR * scatter
    return found


def check_normalized(batch: Batch) -> None:
    """Refuse vectors to the Sun that are directions where three noisy numbers are expected.

    Raises
    ------
    ValueError
        Naming the kind of sensor that they are of.
    """
    for sensor, rows in zip(batch.suite.sensors, batch.sensors, strict=True):
        seen = np.isfinite(rows[:, 0, 0])
        if not isinstance(sensor, SunSensor) or sensor.unit_length or seen.sum() < _FEWEST:
            continue
        length, noise = _length(rows[seen, 0]), min(sensor.noise())
        scatter = float(np.median(np.abs(length - np.median(length))))
        if scatter < _NORMALIZED * noise:
            raise ValueError(
                f"{sensor.name}: the lengths of its vectors scatter by {scatter:.2g}, where noise "
                f"of {noise:.2g} along each axis is expected: these are directions, of two numbers "
                f'each. Expected kind = "{TwoAxisSunSensor.kind}", not "{sensor.kind}"'
            )


def _length(vectors: Floats) -> Floats:
    with np.errstate(over="ignore"):
        length: Floats = np.linalg.norm(vectors, axis=1)
    return length
