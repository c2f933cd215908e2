"""What gyro and sensors report: all that an estimator gets to know, whoever made it."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from mgeo_attitude._typing import Bools, Floats
from mgeo_attitude.geometry.rotation import rotate
from mgeo_attitude.sensors.base import Sensor

#: State of what the gyro's noise in the step to a sample takes from the body's rate [rad/s].
NOISE = "rate_noise"


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
        The k vectors that each sensor reports at every sample, NaN where it reports nothing; one
        that reports a number has shape (n + 1, 1, 1).
    """

    durations: Floats
    gyro: Floats
    sensors: tuple[Floats, ...]

    def where(self, available: Bools) -> Readings:
        """The same without what is reported where a sensor is not available, shape (n + 1, s)."""
        each = zip(available.T, self.sensors, strict=True)
        kept = tuple(np.where(there[:, None, None], rows, np.nan) for there, rows in each)
        return dataclasses.replace(self, sensors=kept)


def as_array(report: Any) -> Floats:
    """What `Sensor.measured` returns as one array, shape (..., k, 3)."""
    vectors = report if isinstance(report, tuple) else (report,)
    return np.stack(np.broadcast_arrays(*vectors), axis=-2)


def as_reported(array: Floats) -> Any:
    """Inverse of `as_array`."""
    vectors = tuple(np.moveaxis(array, -2, 0))
    return vectors if len(vectors) > 1 else vectors[0]


def n_vectors(sensor: Sensor) -> int:
    """How many vectors the sensor reports; NotImplementedError if it does not say."""
    zero, still = dict.fromkeys(sensor.states(), np.zeros(3)), np.zeros(3)
    looks = [np.array([1.0, 0.0, 0.0]), *np.zeros((sensor.n_gradient + len(sensor.delay()), 3))]
    return len(as_array(sensor.measured(*taken(sensor, zero, looks, lambda vector: vector, still))))


def taken(
    sensor: Sensor,
    states: Mapping[str, Any],
    looks: Sequence[Floats],
    to_body: Callable[[Any], Any],
    rate: Floats,
) -> tuple[SimpleNamespace, Any]:
    """The arguments of `Sensor.measured` at the time at which a reading was taken.

    A delay turns the body back, at the rate it has; the vector goes back along its change. That is
    so about each body axis and along it by its own part of the delay, which are `Alike`. What the
    rate is off by is added, where that is a state, `NOISE`.

    Parameters
    ----------
    states : mapping
        As `Sensor.measured` has them, and its ``delay``.
    looks : sequence of arrays, shape (..., 3)
        What it looks at, GCRS, see `Suite.looks`.
    to_body : function
        From GCRS to body axes at the time of the sample.
    rate : array, shape (..., 3)
        Of the body [rad/s].
    """
    late = states.get("delay")
    if NOISE in states:
        rate = rate + states[NOISE]

    def then(vector: Any) -> Any:
        turned = to_body(vector)
        return turned if late is None else rotate(late * rate, turned)

    v, *more = map(then, looks)
    if late is not None:
        v = v - late * more.pop()
    return SimpleNamespace(**{**states, "to_body": then, "gradient": more}), v


def in_threes(numbers: Iterable[Sequence[float] | Floats]) -> Floats:
    """What is said of the numbers of each of s sensors, shape (s, 3); ones where one has fewer."""
    return np.array([[*row, 1.0, 1.0][:3] for row in numbers])


def to_channels(sensor: Sensor, vectors: Floats) -> Floats:
    """Readings, shape (n, k, 3), as telemetry has them: shape (n, len(channels)), NaN where none.

    A quaternion is that of `quaternions`.
    """
    if len(sensor.channels) < 4:
        return vectors[:, 0] * sensor.channel_unit.factor
    return _where_finite(vectors, 4, lambda axes: Rotation.from_matrix(axes).as_quat(True))


def from_channels(sensor: Sensor, values: Floats) -> Floats:
    """Inverse of `to_channels`, to rounding; vectors of whatever length are made to unit length."""
    if len(sensor.channels) < 4:
        length = np.linalg.norm(values, axis=1, keepdims=True) if sensor.unit_length else 1.0
        return (values / (length * sensor.channel_unit.factor))[:, None]
    return _where_finite(values, (3, 3), lambda q: Rotation.from_quat(q).as_matrix())


def _where_finite(
    values: Floats, shape: int | tuple[int, ...], convert: Callable[[Floats], Floats]
) -> Floats:
    """Rows converted to others of a shape; NaN where one has a NaN."""
    there = np.isfinite(values.reshape(len(values), -1)).all(axis=1)
    found = np.full((len(values), *np.atleast_1d(shape)), np.nan)
    found[there] = convert(values[there])
    return found
