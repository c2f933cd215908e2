"""Conversion of raw sensor readings to the body frame and to telemetry units."""

from __future__ import annotations

import numpy as np
from mgeo_attitude._typing import Floats
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.sensors.base import Sensor
from mgeo_attitude.settings.errors import expect
from scipy.spatial.transform import Rotation

from mgeo_calibration.telemetry.attitude_hold import compute_frame_rotations
from mgeo_calibration.telemetry.mapping import (
    UNITS,
    MountedChannels,
    SensorChannels,
    convert_to_scalar_last,
)
from mgeo_calibration.telemetry.quantization import estimate_quantization_steps
from mgeo_calibration.telemetry.table import ColumnValues, TelemetryTable

_MAX_NORM_ERROR = 0.01  # largest deviation of a quaternion's norm from one


def convert_readings(
    sensor: Sensor,
    values: ColumnValues,
    table: TelemetryTable,
    scenario: Scenario,
    position: Floats | None,
) -> tuple[Floats, Floats]:
    """Convert the raw readings of a sensor to the body frame and to telemetry units. Return the
    readings and their quantization steps.

    Parameters
    ----------
    values : ColumnValues
        Columns of the sensor.
    position : array, shape (n, 3), optional
        Satellite position in GCRS [m], if the table contains it.

    Returns
    -------
    readings : array, shape (n, k)
    steps : array, shape (k,)
        Quantization step of each channel.

    Raises
    ------
    ValueError
        If a declaration does not apply to the sensor, an angle is 90 deg or more, or a quaternion
        is not normalized.
    """
    rows, entry, _ = values
    assert isinstance(entry, SensorChannels)
    if len(sensor.telemetry_suffixes) == 4:
        return _convert_attitudes(
            sensor, values, table, scenario, position
        ), estimate_quantization_steps(rows)
    for key in ("attitude", "frame"):
        value = getattr(entry, key)
        expect(value is None, key, value, f"none, because {sensor.name} is not a star tracker")
    if len(sensor.telemetry_suffixes) == 1:
        return _convert_diode(sensor, rows, entry)
    if rows.shape[1] == 2:
        step = np.radians(entry.compute_factor("deg") * estimate_quantization_steps(rows).max())
        return _convert_angles(sensor, values, table), np.full(3, step)
    rows[~rows.any(axis=1)] = np.nan  # Many sensors report zeros without a measurement.
    unit = sensor.telemetry_unit.text
    return rotate_to_body(rows * entry.compute_factor(unit), entry), compute_body_steps(
        rows, entry, unit
    )


def rotate_to_body(rows: Floats, entry: MountedChannels) -> Floats:
    """Rotate vectors from sensor axes to body axes in place, using the declared mounting, and
    return the array.
    """
    if entry.is_mounted:
        reported = np.isfinite(rows).all(axis=1)
        rows[reported] = entry.build_body_rotation().apply(rows[reported])
    return rows


def compute_body_steps(rows: Floats, entry: MountedChannels, unit: str) -> Floats:
    """Return the quantization step along each body axis, as the root sum square over the sensor
    axes.

    Parameters
    ----------
    rows : array, shape (n, 3)
        Raw values in the axes and the unit of the table.
    entry : MountedChannels
        Declarations of the columns.
    unit : str
        Unit of the result.
    """
    step = estimate_quantization_steps(rows) * entry.compute_factor(unit)
    steps: Floats = np.sqrt(entry.build_body_rotation().as_matrix() ** 2 @ step**2)
    return steps


def _convert_diode(sensor: Sensor, rows: Floats, entry: SensorChannels) -> tuple[Floats, Floats]:
    """Convert the raw readings of a photodiode, cosines or angles of incidence, to cosines. Return
    the cosines and their quantization step.

    For angles the step in radians is returned, which is an upper bound of the step of the cosine.
    """
    for key in ("quaternion", "dcm"):
        mounted = f"none, because sensors.normal of the scenario mounts {sensor.name}"
        expect(getattr(entry, key) is None, key, getattr(entry, key), mounted)
    if entry.unit not in UNITS["deg"]:
        factor = entry.compute_factor(sensor.telemetry_unit.text)
        return rows * factor, estimate_quantization_steps(rows) * factor
    angles = np.radians(rows * entry.compute_factor("deg"))
    return np.cos(angles), np.radians(
        estimate_quantization_steps(rows) * entry.compute_factor("deg")
    )


def _convert_angles(sensor: Sensor, values: ColumnValues, table: TelemetryTable) -> Floats:
    """Convert the angles atan(x / z) and atan(y / z) in sensor axes to unit vectors in the body
    frame.
    """
    entry = values.entry
    assert isinstance(entry, SensorChannels)
    angles = entry.compute_factor("deg") * values.rows
    if (beyond := np.abs(angles) >= 90.0).any():
        row, column = np.argwhere(beyond)[0]
        raise ValueError(
            f"{values.columns[column]} at {table.format_place(row)} = {angles[row, column]:.6g} "
            f"deg: expected less than 90 deg; declare unit or scale of {sensor.name}, or leave the "
            "cell empty"
        )
    x, y = np.tan(np.radians(angles.T))
    along = np.column_stack([x, y, np.ones_like(x)])
    return rotate_to_body(along / np.linalg.norm(along, axis=1, keepdims=True), entry)


def _convert_attitudes(
    sensor: Sensor,
    values: ColumnValues,
    table: TelemetryTable,
    scenario: Scenario,
    position: Floats | None,
) -> Floats:
    """Convert star tracker readings to scalar-last quaternions from GCRF to body."""
    rows, entry, _ = values
    assert isinstance(entry, SensorChannels)
    entry.compute_factor("-")
    rows[~rows.any(axis=1)] = np.nan  # Many sensors report zeros without a measurement.
    reported = np.flatnonzero(np.isfinite(rows).all(axis=1))
    lengths = np.linalg.norm(rows[reported], axis=1)
    if (np.abs(lengths - 1.0) > _MAX_NORM_ERROR).any():
        k = int(np.argmax(np.abs(lengths - 1.0)))
        raise ValueError(
            f"{sensor.name} at {table.format_place(reported[k])} = "
            f"{rows[reported[k]].tolist()}, of length {lengths[k]:.6g}: expected a quaternion of "
            f"length 1; declare columns and scale of {sensor.name}, or leave the cells empty"
        )
    q = convert_to_scalar_last(rows, entry.scalar)
    inverse, frame = entry.attitude == "sensor-to-frame", entry.frame or "GCRF"
    if not (entry.is_mounted or inverse or frame != "GCRF") or not len(reported):
        return q
    rotations = Rotation.from_quat(q[reported])  # sensor coordinates to frame coordinates
    rotations = (rotations.inv() if inverse else rotations) * entry.build_body_rotation().inv()
    if frame != "GCRF":
        to_gcrs = compute_frame_rotations(frame, scenario, table.times, position)
        rotations = Rotation.from_matrix(to_gcrs[reported]) * rotations
    result = np.full_like(q, np.nan)
    result[reported] = rotations.as_quat(canonical=True)
    return result
