"""Raw values of gyro, sensors, position and housekeeping channels from a table, sorted by time."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import NamedTuple

import numpy as np
import pandas as pd
from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.settings.errors import InvalidValue, format_known_names

from mgeo_calibration.telemetry.columns import (
    assign_unit,
    find_columns,
    find_sensitivity_channels,
    has_columns,
    parse_numbers,
    select_housekeeping,
)
from mgeo_calibration.telemetry.mapping import Channels, SensorChannels, TelemetryMapping
from mgeo_calibration.telemetry.telemetry import format_place, list_column_names
from mgeo_calibration.telemetry.times import convert_times


class ColumnValues(NamedTuple):
    """Raw values of the gyro, the position or one sensor, with column names and declared
    conversion.
    """

    rows: Floats
    entry: Channels
    columns: list[str]


class TelemetryTable(NamedTuple):
    """Raw values of a telemetry table at increasing times, before conversion to the body frame.

    Attributes
    ----------
    times : array, shape (n,)
        Increasing times [s].
    row_numbers : array of int, shape (n,)
        First row of each time.
    values : dict of str to ColumnValues
        Raw values of ``gyro``, ``position`` and each sensor.
    housekeeping : dict of str to array
        Housekeeping channels: all other numeric columns.
    """

    times: Floats
    row_numbers: Ints
    values: dict[str, ColumnValues]
    housekeeping: dict[str, Floats]

    def format_place(self, k: int) -> str:
        return format_place(k, self.times, self.row_numbers)


def read_values(
    frame: pd.DataFrame, scenario: Scenario, mapping: TelemetryMapping
) -> TelemetryTable:
    """Read the raw values of a telemetry table. Rows are sorted by time, and rows with equal times
    are merged.

    Raises
    ------
    ValueError
        If a column is missing, a cell is not a number or a time, or a column has two values at one
        time.
    """
    entries = _collect_entries(frame, scenario, mapping)
    of_time = [mapping.time] + ([mapping.time_fraction] if mapping.time_fraction else [])
    names = [column for _, own in entries.values() for column in own]
    columns = find_columns(frame, [*of_time, *names])
    series = {name: frame.iloc[:, column.index] for name, column in columns.items()}
    times = convert_times([series[name] for name in of_time], mapping, scenario.epoch)
    values = []
    for owner, (entry, own) in entries.items():
        with prefix_errors(owner):
            for name, scale, offset in zip(own, *entry.expand_conversion(len(own)), strict=True):
                values.append(columns[name].sign * (scale * parse_numbers(series[name]) + offset))
    followed_channels = {each.channel for each in scenario.suite.sensitivities_by_key.values()}
    used = {column.index for column in columns.values()}
    others = select_housekeeping(frame, used, followed_channels)
    find_sensitivity_channels(scenario.suite, others)
    others = _merge_channels(times, others)
    table = np.column_stack(values)
    del values  # The columns take as much memory as the table.
    at, table = _merge_rows(times, table, names)
    first = np.unique(times, return_index=True)[1] + 1
    ends = np.cumsum([len(own) for _, own in entries.values()])
    result = {
        name: ColumnValues(rows, assign_unit(name, entry, [columns[column] for column in own]), own)
        for (name, (entry, own)), rows in zip(
            entries.items(), np.hsplit(table, ends[:-1]), strict=True
        )
    }
    return TelemetryTable(at, first, result, others)


def _collect_entries(
    frame: pd.DataFrame, scenario: Scenario, mapping: TelemetryMapping
) -> dict[str, tuple[Channels, list[str]]]:
    names = [sensor.name for sensor in scenario.sensors]
    declared: dict[str, SensorChannels] = {}
    for i, entry in enumerate(mapping.sensors):
        if entry.name not in names:
            expected = f"unknown sensor{format_known_names(entry.name, names)}"
            raise InvalidValue(f"sensors[{i}].name", entry.name, expected)
        if entry.name in declared:
            raise InvalidValue(f"sensors[{i}].name", entry.name, "expected each sensor once")
        declared[entry.name] = entry
    entries: dict[str, tuple[Channels, list[str]]] = {
        "gyro": (
            mapping.gyro,
            [] if mapping.gyro.reference_axes else _list_columns("gyro", mapping.gyro),
        )
    }
    for sensor in scenario.sensors:
        channel = declared.get(sensor.name, SensorChannels(name=sensor.name))
        widths = (3, 2) if sensor.has_unit_length else (len(sensor.telemetry_suffixes),)
        entries[sensor.name] = channel, _list_columns(sensor.name, channel, *widths)
    position = _list_columns("position", mapping.position)
    if "position" not in names and (mapping.position.columns or has_columns(frame, position)):
        entries["position"] = mapping.position, position
    return entries


@contextmanager
def prefix_errors(name: str) -> Iterator[None]:
    """Context manager that adds the name of a gyro, sensor or position to the key of an
    InvalidValue.
    """
    try:
        yield
    except InvalidValue as error:
        raise error.prefix_key(name) from None


def _list_columns(
    name: str, entry: Channels, width: int = 3, *alternative_widths: int
) -> list[str]:
    columns = list_column_names(name, width) if entry.columns is None else list(entry.columns)
    if len(columns) not in (width, *alternative_widths):
        expected = " or ".join(map(str, (width, *alternative_widths)))
        raise ValueError(f"columns of {name} = {columns}: expected {expected} names")
    return columns


def _merge_rows(times: Floats, table: Floats, names: Sequence[str]) -> tuple[Floats, Floats]:
    """Merge the rows with equal times. Return the times in increasing order and one row of values
    per time.

    Raises
    ------
    ValueError
        If a column has two values at one time.
    """
    rows = pd.DataFrame(table).groupby(times)
    low, high = rows.min(), rows.max()
    if (differs := low.to_numpy() < high.to_numpy()).any():
        row, column = np.argwhere(differs)[0]
        time = low.index[row]
        values = float(low.iloc[row, column]), float(high.iloc[row, column])
        here = [int(np.flatnonzero((times == time) & (table[:, column] == v))[0]) for v in values]
        raise ValueError(
            f"{names[column]} at time {time:.6f} s = {values[0]!r} in row {here[0] + 1} and "
            f"{values[1]!r} in row {here[1] + 1}: expected one value per time. Remove one row, "
            "or declare time_fraction if a second column contains fractions of a second"
        )
    return low.index.to_numpy(copy=True), low.to_numpy(copy=True)


def _merge_channels(times: Floats, channels: Mapping[str, Floats]) -> dict[str, Floats]:
    """Return housekeeping channels at the distinct times in increasing order. Missing values are
    interpolated linearly.
    """
    order, at = np.argsort(times, kind="stable"), np.unique(times)
    result = {}
    for name, values in channels.items():
        filled = order[np.isfinite(values[order])]
        result[name] = np.interp(at, times[filled], values[filled])
    return result
