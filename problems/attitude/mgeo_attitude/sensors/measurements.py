"""Measurements of gyro and sensors as arrays, simulated or recorded."""

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

#: Name of the state of the rate error by gyro noise in the step before a sample [rad/s].
RATE_NOISE = "rate_noise"


@dataclass(frozen=True)
class Measurements:
    """Measurements of a run of n steps.

    Attributes
    ----------
    durations : array, shape (n,)
        Duration of each step [s].
    gyro : array, shape (n, 3)
        Mean measured rate of each step [rad/s].
    sensors : tuple of arrays, shape (n + 1, k, 3)
        The k vectors of each sensor at every sample, NaN without a measurement. A scalar sensor has
        shape (n + 1, 1, 1).
    """

    durations: Floats
    gyro: Floats
    sensors: tuple[Floats, ...]

    def mask(self, available: Bools) -> Measurements:
        """Return the measurements at available samples; all others become NaN.

        Parameters
        ----------
        available : array of bool, shape (n + 1, n_sensors)
        """
        each = zip(available.T, self.sensors, strict=True)
        readings = tuple(np.where(there[:, None, None], rows, np.nan) for there, rows in each)
        return dataclasses.replace(self, sensors=readings)


def stack_measurement(measurement: Any) -> Floats:
    """Stack the result of `Sensor.measured` into one array, shape (..., k, 3)."""
    vectors = measurement if isinstance(measurement, tuple) else (measurement,)
    return np.stack(np.broadcast_arrays(*vectors), axis=-2)


def unstack_measurement(array: Floats) -> Any:
    """Split an array into the form of `Sensor.measured`; the inverse of `stack_measurement`."""
    vectors = tuple(np.moveaxis(array, -2, 0))
    return vectors if len(vectors) > 1 else vectors[0]


def count_vectors(sensor: Sensor) -> int:
    """Return the number of vectors that a sensor measures.

    Raises
    ------
    NotImplementedError
        If the sensor does not define `measured`.
    """
    zero, still = dict.fromkeys(sensor.states(), np.zeros(3)), np.zeros(3)
    looks = [
        np.array([1.0, 0.0, 0.0]),
        *np.zeros((sensor.n_gradient + len(sensor.latency_states()), 3)),
    ]
    return len(
        stack_measurement(
            sensor.predict_measurement(
                *apply_latency(sensor, zero, looks, lambda vector: vector, still)
            )
        )
    )


def apply_latency(
    sensor: Sensor,
    states: Mapping[str, Any],
    reference_vectors: Sequence[Floats],
    to_body: Callable[[Any], Any],
    rate: Floats,
) -> tuple[SimpleNamespace, Any]:
    """Return the arguments of `Sensor.measured` at the time of a measurement with latency.

    The latency rotates the body back by its rate, and moves the reference vector back by its
    derivative. The three components of the latency, one for each body axis, are nearly equal
    (`ScalarConstant`). If the rate error `NOISE` is a state, it is added to the rate.

    Parameters
    ----------
    sensor : Sensor
    states : mapping
        States for `Sensor.measured`, and ``delay``.
    reference_vectors : sequence of arrays, shape (..., 3)
        Reference vectors in GCRS; see `Suite.looks`.
    to_body : function
        Rotation from GCRS to body axes at the time stamp.
    rate : array, shape (..., 3)
        Body rate [rad/s].

    Returns
    -------
    x : SimpleNamespace
    v : array, shape (..., 3)
        Reference vector in body axes.
    """
    late = states.get("latency")
    if RATE_NOISE in states:
        rate = rate + states[RATE_NOISE]

    def then(vector: Any) -> Any:
        turned = to_body(vector)
        return turned if late is None else rotate(late * rate, turned)

    v, *more = map(then, reference_vectors)
    if late is not None:
        v = v - late * more.pop()
    return SimpleNamespace(**{**states, "to_body": then, "gradient": more}), v


def pad_to_three(numbers: Iterable[Sequence[float] | Floats]) -> Floats:
    """Return up to three numbers per sensor as an array, shape (s, 3), padded with ones."""
    return np.array([[*row, 1.0, 1.0][:3] for row in numbers])


def to_telemetry(sensor: Sensor, vectors: Floats) -> Floats:
    """Convert measurements to telemetry columns, with NaN for missing measurements.

    Parameters
    ----------
    sensor : Sensor
    vectors : array, shape (n, k, 3)

    Returns
    -------
    array, shape (n, len(channels))
        Vector components in the channel's unit, or a quaternion as in `quaternions_from_matrices`.
    """
    if len(sensor.telemetry_suffixes) < 4:
        return vectors[:, 0] * sensor.telemetry_unit.factor
    return _convert_finite_rows(vectors, 4, lambda axes: Rotation.from_matrix(axes).as_quat(True))


def from_telemetry(sensor: Sensor, values: Floats) -> Floats:
    """Convert telemetry columns to measurements; the inverse of `to_telemetry`.

    Vectors of sensors with `has_unit_length` are normalized.
    """
    if len(sensor.telemetry_suffixes) < 4:
        length = np.linalg.norm(values, axis=1, keepdims=True) if sensor.has_unit_length else 1.0
        return (values / (length * sensor.telemetry_unit.factor))[:, None]
    return _convert_finite_rows(values, (3, 3), lambda q: Rotation.from_quat(q).as_matrix())


def _convert_finite_rows(
    values: Floats, shape: int | tuple[int, ...], convert: Callable[[Floats], Floats]
) -> Floats:
    """Convert rows to a new shape; rows with NaN become NaN."""
    there = np.isfinite(values.reshape(len(values), -1)).all(axis=1)
    result = np.full((len(values), *np.atleast_1d(shape)), np.nan)
    result[there] = convert(values[there])
    return result
