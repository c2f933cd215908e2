"""Tables of telemetry, from CSV, Parquet or a DataFrame, checked where they come in."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
from mgeo_attitude._typing import Floats
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.sensors.base import Sensor
from mgeo_attitude.settings.errors import InvalidValue, expect, known_names
from scipy.spatial.transform import Rotation

from mgeo_calibration.telemetry.checks import (
    check_changes,
    check_saturation,
    check_telemetry,
    followed,
)
from mgeo_calibration.telemetry.columns import (
    find_columns,
    has_columns,
    numbers,
    other_columns,
    seconds,
    with_unit,
)
from mgeo_calibration.telemetry.files import read_table
from mgeo_calibration.telemetry.gyro_samples import held, means
from mgeo_calibration.telemetry.mapping import Channels, GyroChannels, TelemetryMapping
from mgeo_calibration.telemetry.quantization import resolution
from mgeo_calibration.telemetry.telemetry import Telemetry, channels

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


class _Rows(NamedTuple):
    """What a table has of gyro, position or a sensor, and how its columns are called."""

    rows: Floats
    entry: Channels
    columns: list[str]


def _telemetry(frame: pd.DataFrame, scenario: Scenario, mapping: TelemetryMapping) -> Telemetry:
    times, found, others = _read(frame, scenario, mapping)
    gyro, position = found["gyro"], found.get("position")
    with _named("gyro"):
        rates, step = _rates(times, gyro, mapping.gyro, scenario)
    steps, where = {"gyro": step}, None
    if position is not None:
        with _named("position"):
            where = _turned(position.rows, position.entry, "m")
    sensors = {}
    for sensor in scenario.sensors:
        with _named(sensor.name):
            sensors[sensor.name], steps[sensor.name] = _readings(sensor, found[sensor.name])
    telemetry = Telemetry(
        times=times,
        gyro_deg_s=rates,
        sensors=sensors,
        position=where,
        steps=steps,
        others=others,
        has_gyro=not mapping.gyro.holds,
    )
    check_telemetry(telemetry, scenario)
    for sensor in scenario.sensors:
        check_changes(found[sensor.name].columns, found[sensor.name].rows)
    if not mapping.gyro.holds:
        check_changes(gyro.columns, gyro.rows)
        check_saturation(gyro.columns, gyro.rows, gyro.entry.unit or "deg/s")
    return telemetry


def _read(
    frame: pd.DataFrame, scenario: Scenario, mapping: TelemetryMapping
) -> tuple[Floats, dict[str, _Rows], dict[str, Floats]]:
    """Times in order, what there is at each of gyro, position and sensors, and other columns."""
    asked = _entries(frame, scenario, mapping)
    wanted = [mapping.time, *(column for _, own in asked.values() for column in own)]
    columns = find_columns(frame, wanted)
    times = seconds(frame.iloc[:, columns[mapping.time].place], mapping.time_format, scenario)
    table = np.column_stack(
        [column.sign * numbers(frame.iloc[:, column.place]) for column in [*columns.values()][1:]]
    )
    followed_channels = {each.channel for each in scenario.suite.influence_keys.values()}
    used = {column.place for column in columns.values()}
    others = other_columns(frame, used, followed_channels)
    followed(scenario.suite, others)
    others = _merged_channels(times, others)
    times, table = _merged(times, table, wanted[1:])
    ends = np.cumsum([len(own) for _, own in asked.values()])
    found = {
        name: _Rows(rows, with_unit(name, entry, [columns[column] for column in own]), own)
        for (name, (entry, own)), rows in zip(
            asked.items(), np.hsplit(table, ends[:-1]), strict=True
        )
    }
    return times, found, others


def _rates(
    times: Floats, read: _Rows, gyro: GyroChannels, scenario: Scenario
) -> tuple[Floats, Floats]:
    """Mean rates [deg/s] about body axes, and the steps in which the gyro counts."""
    rows, entry, columns = read
    if gyro.holds:
        rates, step = _turned(held(gyro.holds, scenario, times), entry, "deg/s"), np.zeros(3)
    else:
        step = _steps(rows, entry, "deg/s")
        _check_range(times, columns, rows * entry.factor("deg/s"), gyro.range_deg_s)
        rates = _turned(rows, entry, "deg/s")
    if gyro.holds or gyro.rate == "instantaneous":
        there = np.isfinite(rates).all(axis=1)
        rates[there] = means(times[there], rates[there])
    return rates, step


def _readings(sensor: Sensor, read: _Rows) -> tuple[Floats, Floats]:
    """What a sensor has reported, and the steps in which it counts."""
    rows, entry, _ = read
    if rows.shape[1] == 2:
        step = np.radians(entry.factor("deg") * resolution(rows).max())
        return _reported(sensor, rows, entry), np.full(3, step)
    if rows.shape[1] > 2:  # many report zeros so that they see nothing
        rows[~rows.any(axis=1)] = np.nan
    reported = _reported(sensor, rows, entry)
    return reported, _steps(rows, entry, sensor.channel_unit.text)


def _entries(
    frame: pd.DataFrame, scenario: Scenario, mapping: TelemetryMapping
) -> dict[str, tuple[Channels, list[str]]]:
    """What a mapping says of gyro, sensors and, if it is there, position, and their columns."""
    names = [sensor.name for sensor in scenario.sensors]
    given: dict[str, Channels] = {}
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
        channel = given.get(sensor.name, Channels())
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
        raise ValueError(
            f"time {low.index[row]:.6f} s occurs with {names[column]} = {low.iloc[row, column]} "
            f"and {high.iloc[row, column]}: expected one of the two"
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


def _turned(rows: Floats, entry: Channels, unit: str) -> Floats:
    """In body axes and in the unit of telemetry."""
    scaled = rows * entry.factor(unit)
    if entry.quaternion is None and entry.dcm is None:
        return scaled
    there = np.isfinite(rows).all(axis=1)
    scaled[there] = entry.to_body().apply(scaled[there])
    return scaled


def _steps(rows: Floats, entry: Channels, unit: str) -> Floats:
    """In which channels count, in body axes, as 1-sigmas of rounded numbers add up."""
    step = resolution(rows)
    if rows.shape[1] == 3:
        step = np.sqrt(entry.to_body().as_matrix() ** 2 @ (step * entry.factor(unit)) ** 2)
    return step


def _reported(sensor: Sensor, rows: Floats, entry: Channels) -> Floats:
    """Channels of a sensor, as if it were mounted along the body axes."""
    if rows.shape[1] == 2:
        angles = entry.factor("deg") * rows
        if (np.abs(angles) >= 90.0).any():
            worst = float(np.nanmax(np.abs(angles)))
            raise ValueError(f"{sensor.name}: an angle of {worst:.6g} deg: expected less than 90")
        x, y = np.tan(np.radians(angles.T))
        along = np.column_stack([x, y, np.ones_like(x)])
        along /= np.linalg.norm(along, axis=1, keepdims=True)
        found: Floats = entry.to_body().apply(along)
        return found
    if len(sensor.channels) == 1:
        for key in ("quaternion", "dcm"):
            mounted = f"none: how {sensor.name} is mounted says sensors.normal of the scenario"
            expect(getattr(entry, key) is None, key, getattr(entry, key), mounted)
        return rows * entry.factor(sensor.channel_unit.text)
    if len(sensor.channels) == 3:
        return _turned(rows, entry, sensor.channel_unit.text)
    entry.factor("-")
    there = np.isfinite(rows).all(axis=1)
    lengths = np.linalg.norm(rows[there], axis=1)
    if (np.abs(lengths - 1.0) > _UNIT_LENGTH).any():
        length = lengths[np.argmax(np.abs(lengths - 1.0))]
        raise ValueError(f"{sensor.name}: a quaternion of length {length:.6g}: expected 1")
    if entry.quaternion is None and entry.dcm is None:
        return rows
    turned = rows.copy()
    turned[there] = (Rotation.from_quat(rows[there]) * entry.to_body().inv()).as_quat(True)
    return turned


def _check_range(times: Floats, names: Sequence[str], gyro: Floats, most: float | None) -> None:
    """Of rates along the gyro's own axes [deg/s]."""
    saturated = np.abs(gyro) >= (np.inf if most is None else most)
    if saturated.any():
        row, axis = np.argwhere(saturated)[0]
        raise ValueError(
            f"{names[axis]} at time {times[row]:.6f} s = {gyro[row, axis]:.6g} deg/s: the "
            f"gyro saturates at range_deg_s = {most:g}"
        )
