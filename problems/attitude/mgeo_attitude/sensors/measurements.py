"""Measurements of gyro and sensors as arrays, simulated or from telemetry."""

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

#: Name of the state for the rate error due to gyro noise in the step before a sample [rad/s].
RATE_NOISE = "rate_noise"


@dataclass(frozen=True)
class Measurements:
    """Gyro and sensor measurements over n filter steps, as arrays.

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
        """Return a copy with NaN in place of unavailable sensor measurements.

        Parameters
        ----------
        available : array of bool, shape (n + 1, n_sensors)
            Whether each sensor measures at each sample.
        """
        pairs = zip(available.T, self.sensors, strict=True)
        masked = tuple(np.where(mask[:, None, None], vectors, np.nan) for mask, vectors in pairs)
        return dataclasses.replace(self, sensors=masked)


def stack_measurement(measurement: Any) -> Floats:
    """Stack the vectors of a measurement, such as the axes of a star tracker, in one array.

    Parameters
    ----------
    measurement : array or tuple of arrays, shape (..., 3)
        Result of `Sensor.predict_measurement`.

    Returns
    -------
    array, shape (..., k, 3)
    """
    vectors = measurement if isinstance(measurement, tuple) else (measurement,)
    return np.stack(np.broadcast_arrays(*vectors), axis=-2)


def unstack_measurement(array: Floats) -> Any:
    """Split an array of stacked vectors into the format of `Sensor.predict_measurement`.

    The result is an array for one vector, or a tuple of arrays for several vectors. This is the
    inverse of `stack_measurement`.
    """
    vectors = tuple(np.moveaxis(array, -2, 0))
    return vectors if len(vectors) > 1 else vectors[0]


def count_vectors(sensor: Sensor) -> int:
    """Return the number of vectors in a measurement of a sensor, such as 3 for a star tracker.

    Raises
    ------
    NotImplementedError
        If the sensor does not define `predict_measurement`.
    """
    states, rate = dict.fromkeys(sensor.states(), np.zeros(3)), np.zeros(3)
    reference_vectors = [
        np.array([1.0, 0.0, 0.0]),
        *np.zeros((sensor.n_auxiliary_vectors + len(sensor.latency_states()), 3)),
    ]
    return len(
        stack_measurement(
            sensor.predict_measurement(
                *apply_latency(sensor, states, reference_vectors, lambda vector: vector, rate)
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
    """Return the arguments of `Sensor.predict_measurement`, corrected for the latency.

    The arguments refer to the time of the measurement, which precedes the time stamp. The latency
    rotates the body back by its rate, and moves the reference vector back by its derivative. The
    three components of the latency, one for each body axis, are nearly equal (`ScalarConstant`). If
    the rate error `RATE_NOISE` is a state, it is added to the rate.

    Parameters
    ----------
    sensor : Sensor
        Sensor with or without latency.
    states : mapping
        Error states of the sensor, including ``latency`` if it has one.
    reference_vectors : sequence of arrays, shape (..., 3)
        Reference vector and auxiliary vectors in GCRS; see `Suite.list_vector_indices`.
    to_body : function
        Rotation from GCRS to body axes at the time stamp.
    rate : array, shape (..., 3)
        Body rate [rad/s].

    Returns
    -------
    x : SimpleNamespace
        Error states, rotation to body axes and auxiliary vectors at the time of the measurement.
    v : array, shape (..., 3)
        Reference vector in body axes at the time of the measurement.
    """
    latency = states.get("latency")
    if RATE_NOISE in states:
        rate = rate + states[RATE_NOISE]

    def to_body_at_measurement(vector: Any) -> Any:
        rotated = to_body(vector)
        return rotated if latency is None else rotate(latency * rate, rotated)

    v, *auxiliary_vectors = map(to_body_at_measurement, reference_vectors)
    if latency is not None:
        v = v - latency * auxiliary_vectors.pop()
    x = {**states, "to_body": to_body_at_measurement, "auxiliary_vectors": auxiliary_vectors}
    return SimpleNamespace(**x), v


def stack_noise_sigmas(sigmas: Iterable[Sequence[float] | Floats]) -> Floats:
    """Stack the noise 1-sigmas of all sensors in an array with three columns.

    Sensors with fewer than three components have ones in the remaining columns.
    """
    return np.array([[*row, 1.0, 1.0][:3] for row in sigmas])


def to_telemetry(sensor: Sensor, vectors: Floats) -> Floats:
    """Convert the measured vectors of a sensor to the values of its telemetry columns.

    Missing measurements are NaN.

    Parameters
    ----------
    sensor : Sensor
    vectors : array, shape (n, k, 3)
        Measured vectors, NaN without a measurement.

    Returns
    -------
    array, shape (n, number of `telemetry_suffixes`)
        Vector components in the `telemetry_unit`, or a quaternion as in
        `quaternions_from_matrices`.
    """
    if len(sensor.telemetry_suffixes) < 4:
        return vectors[:, 0] * sensor.telemetry_unit.factor
    return _convert_finite_rows(vectors, 4, lambda axes: Rotation.from_matrix(axes).as_quat(True))


def from_telemetry(sensor: Sensor, values: Floats) -> Floats:
    """Convert the values of a sensor's telemetry columns to measured vectors.

    This is the inverse of `to_telemetry`. Vectors of sensors with `has_unit_length` are normalized.

    Parameters
    ----------
    sensor : Sensor
    values : array, shape (n, number of `telemetry_suffixes`)
        Telemetry columns, NaN without a measurement.

    Returns
    -------
    array, shape (n, k, 3)
    """
    if len(sensor.telemetry_suffixes) < 4:
        length = np.linalg.norm(values, axis=1, keepdims=True) if sensor.has_unit_length else 1.0
        return (values / (length * sensor.telemetry_unit.factor))[:, None]
    return _convert_finite_rows(values, (3, 3), lambda q: Rotation.from_quat(q).as_matrix())


def _convert_finite_rows(
    values: Floats, shape: int | tuple[int, ...], convert: Callable[[Floats], Floats]
) -> Floats:
    """Apply a function to all finite rows of an array, and set the other rows to NaN."""
    finite = np.isfinite(values.reshape(len(values), -1)).all(axis=1)
    result = np.full((len(values), *np.atleast_1d(shape)), np.nan)
    result[finite] = convert(values[finite])
    return result
