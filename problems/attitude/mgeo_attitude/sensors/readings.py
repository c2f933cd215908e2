"""What gyro and sensors report: all that an estimator gets to know, whoever made it."""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.sensors.base import Sensor


@dataclass(frozen=True)
class Readings:
    """Reports of a run of n steps, simulated or recorded.

    Attributes
    ----------
    durations : array, shape (n,)
        Of the steps [s]; they need not be equal.
    gyro : array, shape (n, 3)
        Mean of the reported rate over each step [rad/s].
    sensors : tuple of arrays, shape (n + 1, k, 3)
        The k vectors that each sensor reports at every sample, NaN where it reports nothing.
    """

    durations: Floats
    gyro: Floats
    sensors: tuple[Floats, ...]


def as_array(report: Any) -> Floats:
    """What `Sensor.measured` returns as one array, shape (..., k, 3)."""
    vectors = report if isinstance(report, tuple) else (report,)
    array: Floats = np.stack(np.broadcast_arrays(*vectors), axis=-2)
    return array


def as_reported(array: Floats) -> Any:
    """Inverse of `as_array`."""
    vectors = tuple(np.moveaxis(array, -2, 0))
    return vectors if len(vectors) > 1 else vectors[0]


def n_vectors(sensor: Sensor) -> int:
    """How many vectors the sensor reports; NotImplementedError if it does not say."""
    zero = dict.fromkeys(sensor.states(), np.zeros(3))
    x = SimpleNamespace(to_body=lambda vector: vector, gradient=np.zeros((3, 3)), **zero)
    return len(as_array(sensor.measured(x, np.array([1.0, 0.0, 0.0]))))
