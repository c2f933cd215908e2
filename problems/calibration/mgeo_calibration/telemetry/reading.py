"""Tables of telemetry, from CSV, Parquet or a DataFrame, checked where they come in."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.environment.frames import lvlh_to_gcrs, rotate, rotation_to_gcrs
from mgeo_attitude.environment.times import instants
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.sensors.base import Sensor
from mgeo_attitude.settings.errors import InvalidValue, expect, known_names
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from mgeo_calibration.telemetry.checks import refuse
from mgeo_calibration.telemetry.columns import (
    find_columns,
    followed,
    has_columns,
    numbers,
    other_columns,
    with_unit,
)
from mgeo_calibration.telemetry.files import read_table
from mgeo_calibration.telemetry.finding import Samples
from mgeo_calibration.telemetry.gyro_samples import means, reported
from mgeo_calibration.telemetry.held import held
from mgeo_calibration.telemetry.mapping import (
    UNITS,
    Channels,
    GyroChannels,
    MountedChannels,
    SensorChannels,
    TelemetryMapping,
    scalar_last,
)
from mgeo_calibration.telemetry.quantization import resolution
from mgeo_calibration.telemetry.telemetry import Telemetry, channels, place
from mgeo_calibration.telemetry.times import seconds

_UNIT_LENGTH = 0.01  # a quaternion may be off by this


def read_telemetry(
    source: Path | str | pd.DataFrame,
    scenario: Scenario,
    mapping: TelemetryMapping | None = None,
) -> Telemetry:
    """Read a table whose columns are those of `Telemetry.frame`, or what `mapping` says.

    Rows may stand in any order and repeat each other; those of one time are put together, so that
    sensors may have rows of their own. An entry is empty where there was no sample; a vector or
    quaternion of zeros is none, either. Other columns of numbers are `others`. Names differ neither
    by case nor by a unit in brackets, which says what is in the column unless the mapping does.

    Parameters
    ----------
    source : path or DataFrame
        See `read_table` for what files may be.
    scenario : Scenario
        Its epoch, and the names and kinds of its sensors.

    Raises
    ------
    OSError
        If it cannot be read.
    ImportError
        For Parquet without pyarrow.
    ValueError
        Naming file, row and column of what is missing, no number, unknown, given twice with
        different values, stuck, saturated or outside the field model.

    Examples
    --------
    >>> from mgeo_attitude import Scenario
    >>> from mgeo_calibration import fly, read_telemetry
    >>> scenario = Scenario.from_dict({"preset": "paper", "duration": 900.0})
    >>> design = [0.5, 0.3, -0.2, 300.0, -0.3, 0.6, 0.2, 300.0, 0.2, -0.4, 0.7, 300.0]
    >>> fly(scenario, design, seed=1).frame().to_csv("telemetry.csv", index=False)
    >>> read_telemetry("telemetry.csv", scenario).sensors["mag"].shape
    (901, 3)
    """
    if isinstance(source, pd.DataFrame):
        return _telemetry(source, scenario, mapping or TelemetryMapping())
    path = Path(source)
    try:
        return _telemetry(read_table(path), scenario, mapping or TelemetryMapping())
    except ValueError as error:
        raise ValueError(f"{path}: {str(error).strip()}") from error


def _telemetry(frame: pd.DataFrame, scenario: Scenario, mapping: TelemetryMapping) -> Telemetry:
    table = _read(frame, scenario, mapping)
    times, found = table.times, table.found
    with _named("gyro"):
        rates, step = _rates(times, found["gyro"], mapping.gyro, scenario)
    steps, position = {"gyro": step}, None
    if "position" in found:
        with _named("position"):
            position = found["position"].rows * mapping.position.factor("m")
            frames = rotation_to_gcrs(
                mapping.position.frame or "GCRF", instants(scenario.epoch, times)
            )
            position = rotate(frames, position)
    sensors = {}
    for sensor in scenario.sensors:
        with _named(sensor.name):
            sensors[sensor.name], steps[sensor.name] = _readings(
                sensor, found[sensor.name], table, scenario, position
            )
    telemetry = Telemetry(
        times=times,
        gyro_deg_s=rates,
        sensors=sensors,
        position=position,
        steps=steps,
        others=table.others,
        rows=table.numbers,
        has_gyro=not mapping.gyro.holds,
    )
    reported(telemetry)
    if not any(np.isfinite(rows).any() for rows in sensors.values()):
        raise ValueError(f"{', '.join(sensors)}: expected a sample of one of them")
    names = [*(["gyro"] if telemetry.has_gyro else []), *sensors]
    columns = {name: (found[name].columns, found[name].rows) for name in names}
    refuse(Samples(scenario, telemetry, columns, mapping))
    return telemetry


class _Rows(NamedTuple):
    """Values of gyro, position or a sensor, their declarations, and their columns."""

    rows: Floats
    entry: Channels
    columns: list[str]


class _Table(NamedTuple):
    """Times in order, rows of their first samples, values by owner, and other columns."""

    times: Floats
    numbers: Ints
    found: dict[str, _Rows]
    others: dict[str, Floats]

    def place(self, k: int) -> str:
        return place(k, self.times, self.numbers)


def _read(frame: pd.DataFrame, scenario: Scenario, mapping: TelemetryMapping) -> _Table:
    asked = _entries(frame, scenario, mapping)
    of_time = [mapping.time] + ([mapping.time_fraction] if mapping.time_fraction else [])
    names = [column for _, own in asked.values() for column in own]
    columns = find_columns(frame, [*of_time, *names])
    series = {name: frame.iloc[:, column.place] for name, column in columns.items()}
    times = seconds([series[name] for name in of_time], mapping, scenario.epoch)
    values = []
    for owner, (entry, own) in asked.items():
        with _named(owner):
            for name, scale, offset in zip(own, *entry.conversion(len(own)), strict=True):
                values.append(columns[name].sign * (scale * numbers(series[name]) + offset))
    followed_channels = {each.channel for each in scenario.suite.influence_keys.values()}
    used = {column.place for column in columns.values()}
    others = other_columns(frame, used, followed_channels)
    followed(scenario.suite, others)
    others = _merged_channels(times, others)
    table = np.column_stack(values)
    del values  # of a million rows they take as much as the table
    at, table = _merged(times, table, names)
    first = np.unique(times, return_index=True)[1] + 1
    ends = np.cumsum([len(own) for _, own in asked.values()])
    found = {
        name: _Rows(rows, with_unit(name, entry, [columns[column] for column in own]), own)
        for (name, (entry, own)), rows in zip(
            asked.items(), np.hsplit(table, ends[:-1]), strict=True
        )
    }
    return _Table(at, first, found, others)


def _rates(
    times: Floats, read: _Rows, gyro: GyroChannels, scenario: Scenario
) -> tuple[Floats, Floats]:
    """Mean rates [deg/s] about body axes, and the steps in which the gyro counts."""
    rows, entry, _ = read
    assert isinstance(entry, GyroChannels)
    if gyro.holds:
        rates, step = _mounted(held(gyro.holds, scenario, times), entry), np.zeros(3)
    else:
        step = _steps(rows, entry, "deg/s")
        rates = _mounted(rows * entry.factor("deg/s"), entry)
    if gyro.holds or gyro.rate == "instantaneous":
        there = np.isfinite(rates).all(axis=1)
        rates[there] = means(times[there], rates[there])
    return rates, step


def _readings(
    sensor: Sensor, read: _Rows, table: _Table, scenario: Scenario, position: Floats | None
) -> tuple[Floats, Floats]:
    """Readings of a sensor along body axes, and the steps in which it counts."""
    rows, entry, _ = read
    assert isinstance(entry, SensorChannels)
    if len(sensor.channels) == 4:
        return _attitudes(sensor, read, table, scenario, position), resolution(rows)
    for key in ("attitude", "frame"):
        value = getattr(entry, key)
        expect(value is None, key, value, f"none: {sensor.name} is no star tracker")
    if len(sensor.channels) == 1:
        return _diode(sensor, rows, entry)
    if rows.shape[1] == 2:
        step = np.radians(entry.factor("deg") * resolution(rows).max())
        return _from_angles(sensor, read, table), np.full(3, step)
    rows[~rows.any(axis=1)] = np.nan  # many report zeros so that they see nothing
    unit = sensor.channel_unit.text
    return _mounted(rows * entry.factor(unit), entry), _steps(rows, entry, unit)


def _entries(
    frame: pd.DataFrame, scenario: Scenario, mapping: TelemetryMapping
) -> dict[str, tuple[Channels, list[str]]]:
    """Declarations of gyro, sensors and, if it is there, position, and their columns."""
    names = [sensor.name for sensor in scenario.sensors]
    given: dict[str, SensorChannels] = {}
    for i, entry in enumerate(mapping.sensors):
        if entry.name not in names:
            expected = f"unknown sensor{known_names(entry.name, names)}"
            raise InvalidValue(f"sensors[{i}].name", entry.name, expected)
        if entry.name in given:
            raise InvalidValue(f"sensors[{i}].name", entry.name, "is named twice: expected it once")
        given[entry.name] = entry
    asked: dict[str, tuple[Channels, list[str]]] = {
        "gyro": (mapping.gyro, [] if mapping.gyro.holds else _asked("gyro", mapping.gyro))
    }
    for sensor in scenario.sensors:
        channel = given.get(sensor.name, SensorChannels(name=sensor.name))
        widths = (3, 2) if sensor.unit_length else (len(sensor.channels),)
        asked[sensor.name] = channel, _asked(sensor.name, channel, *widths)
    position = _asked("position", mapping.position)
    if "position" not in names and (mapping.position.columns or has_columns(frame, position)):
        asked["position"] = mapping.position, position
    return asked


@contextmanager
def _named(name: str) -> Iterator[None]:
    """Puts whose it is before the key of what is wrong with a mapping."""
    try:
        yield
    except InvalidValue as error:
        raise error.under(name) from None


def _asked(name: str, entry: Channels, width: int = 3, *others: int) -> list[str]:
    columns = channels(name, width) if entry.columns is None else list(entry.columns)
    if len(columns) not in (width, *others):
        expected = " or ".join(map(str, (width, *others)))
        raise ValueError(f"columns of {name} = {columns}: expected {expected} names")
    return columns


def _merged(times: Floats, table: Floats, names: Sequence[str]) -> tuple[Floats, Floats]:
    """Rows in the order of their times, those of one time put together."""
    rows = pd.DataFrame(table).groupby(times)
    low, high = rows.min(), rows.max()
    if (differs := low.to_numpy() < high.to_numpy()).any():
        row, column = np.argwhere(differs)[0]
        time, values = low.index[row], (low.iloc[row, column], high.iloc[row, column])
        here = [int(np.flatnonzero((times == time) & (table[:, column] == v))[0]) for v in values]
        raise ValueError(
            f"{names[column]} at time {time:.6f} s = {values[0]!r} in row {here[0] + 1} and "
            f"{values[1]!r} in row {here[1] + 1}: expected one value at a time; leave one row out, "
            "or declare time_fraction if a second column has the fractions of a second"
        )
    return low.index.to_numpy(copy=True), low.to_numpy(copy=True)


def _merged_channels(times: Floats, channels: Mapping[str, Floats]) -> dict[str, Floats]:
    """Channels at all times in their order, by lines over what is missing."""
    order, at = np.argsort(times, kind="stable"), np.unique(times)
    found = {}
    for name, values in channels.items():
        there = order[np.isfinite(values[order])]
        found[name] = np.interp(at, times[there], values[there])
    return found


def _mounted(rows: Floats, entry: MountedChannels) -> Floats:
    """Vectors in sensor axes, shape (n, 3), in body axes."""
    if entry.is_mounted:
        there = np.isfinite(rows).all(axis=1)
        rows[there] = entry.to_body().apply(rows[there])
    return rows


def _steps(rows: Floats, entry: MountedChannels, unit: str) -> Floats:
    """Steps of the channels in body axes, as 1-sigmas of rounded numbers add up."""
    step = resolution(rows) * entry.factor(unit)
    steps: Floats = np.sqrt(entry.to_body().as_matrix() ** 2 @ step**2)
    return steps


def _diode(sensor: Sensor, rows: Floats, entry: SensorChannels) -> tuple[Floats, Floats]:
    """Readings of a photodiode, a share of the largest or an angle, and its step."""
    for key in ("quaternion", "dcm"):
        mounted = f"none: sensors.normal of the scenario mounts {sensor.name}"
        expect(getattr(entry, key) is None, key, getattr(entry, key), mounted)
    if entry.unit not in UNITS["deg"]:
        factor = entry.factor(sensor.channel_unit.text)
        return rows * factor, resolution(rows) * factor
    angles = np.radians(rows * entry.factor("deg"))
    return np.cos(angles), np.radians(resolution(rows) * entry.factor("deg"))


def _from_angles(sensor: Sensor, read: _Rows, table: _Table) -> Floats:
    """Directions in body axes of the angles atan(x / z) and atan(y / z) in sensor axes."""
    entry = read.entry
    assert isinstance(entry, SensorChannels)
    angles = entry.factor("deg") * read.rows
    if (beyond := np.abs(angles) >= 90.0).any():
        row, column = np.argwhere(beyond)[0]
        raise ValueError(
            f"{read.columns[column]} at {table.place(row)} = {angles[row, column]:.6g} deg: "
            f"expected less than 90 deg; declare unit or scale of {sensor.name}, or leave the cell "
            "empty"
        )
    x, y = np.tan(np.radians(angles.T))
    along = np.column_stack([x, y, np.ones_like(x)])
    return _mounted(along / np.linalg.norm(along, axis=1, keepdims=True), entry)


def _attitudes(
    sensor: Sensor, read: _Rows, table: _Table, scenario: Scenario, position: Floats | None
) -> Floats:
    """Quaternions from GCRF to the body, scalar last, of a star tracker's."""
    rows, entry, _ = read
    assert isinstance(entry, SensorChannels)
    entry.factor("-")
    rows[~rows.any(axis=1)] = np.nan  # many report zeros so that they see nothing
    there = np.flatnonzero(np.isfinite(rows).all(axis=1))
    lengths = np.linalg.norm(rows[there], axis=1)
    if (np.abs(lengths - 1.0) > _UNIT_LENGTH).any():
        k = int(np.argmax(np.abs(lengths - 1.0)))
        raise ValueError(
            f"{sensor.name} at {table.place(there[k])} = {rows[there[k]].tolist()}, of length "
            f"{lengths[k]:.6g}: expected a quaternion of length 1; declare columns and scale of "
            f"{sensor.name}, or leave the cells empty"
        )
    q = scalar_last(rows, entry.scalar)
    inverse, frame = entry.attitude == "sensor-to-frame", entry.frame or "GCRF"
    if not (entry.is_mounted or inverse or frame != "GCRF") or not len(there):
        return q
    turned = Rotation.from_quat(q[there])  # takes coordinates of the sensor to the frame
    turned = (turned.inv() if inverse else turned) * entry.to_body().inv()
    if frame != "GCRF":
        turned = (
            Rotation.from_matrix(_frames(frame, scenario, table.times, position)[there]) * turned
        )
    found = np.full_like(q, np.nan)
    found[there] = turned.as_quat(canonical=True)
    return found


def _frames(frame: str, scenario: Scenario, times: Floats, position: Floats | None) -> Floats:
    """Matrices that take vectors of a frame to GCRS, shape (n, 3, 3)."""
    if frame != "LVLH":
        return rotation_to_gcrs(frame, instants(scenario.epoch, times))
    if position is None:
        return lvlh_to_gcrs(*scenario.orbit.propagate(scenario.epoch, times))
    known = np.isfinite(position[:, 0])
    course = CubicSpline(times[known], position[known])
    return lvlh_to_gcrs(course(times), course(times, 1))
