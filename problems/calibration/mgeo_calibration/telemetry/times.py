"""Conversion of table times to SI seconds since the epoch of the scenario."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import datetime

import numpy as np
import pandas as pd
from mgeo_attitude._typing import Floats
from mgeo_attitude.environment.times import convert_calendar_seconds, parse_time_stamps

from mgeo_calibration.telemetry.columns import (
    convert_to_numeric,
    format_cell,
    normalize_unit,
    parse_numbers,
    split_name_and_unit,
)
from mgeo_calibration.telemetry.mapping import UNITS, TelemetryMapping

_UTC_OFFSET = r"([+-])(\d\d):?(\d\d)$"


def convert_times(
    columns: Sequence[pd.Series], mapping: TelemetryMapping, epoch: datetime
) -> Floats:
    """Convert time columns with numbers or ISO 8601 times to SI seconds since an epoch.

    Parameters
    ----------
    columns : sequence of Series
        Column of times and, if the mapping declares one, column of fractions.
    mapping : TelemetryMapping
    epoch : datetime

    Returns
    -------
    array, shape (n,)

    Raises
    ------
    ValueError
        With row and value of a cell that is not a time.
    """
    column, *fractions = columns
    if column.dtype.kind == "O" and convert_to_numeric(column.iloc[:1]).notna().all():
        column = pd.Series(parse_numbers(column), name=column.name)
    more = np.zeros(len(column))
    for each in fractions:
        more += UNITS["s"][mapping.time_fraction_unit] * parse_numbers(each)
    if column.dtype.kind in "iuf":
        times = _convert_counts(column, more, mapping, epoch)
    elif mapping.time_epoch is not None:
        raise ValueError(
            f"row 1, {column.name} = {format_cell(column.iloc[0])}: expected a number, because "
            "time_epoch is declared. Remove the key for ISO 8601 times"
        )
    elif column.dtype.kind == "M":
        clock = (pd.to_datetime(column, utc=True) - pd.Timestamp(epoch)).dt.total_seconds()
        result = convert_calendar_seconds(epoch, clock.to_numpy(dtype=float), mapping.time_scale)
        times = result + more
    else:
        stamps = column.astype(str).str.strip()
        times = _parse_stamps(stamps, epoch, mapping.time_scale) + more
    if np.isnan(times).any():
        row = int(np.argmax(np.isnan(times)))
        raise ValueError(
            f"row {row + 1}, {column.name} = {format_cell(column.iloc[row])}: expected a number of "
            "seconds since the epoch, or an ISO 8601 time. Declare time_epoch for another epoch"
        )
    return times


def _convert_counts(
    column: pd.Series, fraction_seconds: Floats, mapping: TelemetryMapping, epoch: datetime
) -> Floats:
    in_name = normalize_unit(split_name_and_unit(column.name)[1])
    unit = mapping.time_unit or (in_name if in_name in UNITS["s"] else "s")
    counted, start = UNITS["s"][unit] * parse_numbers(column), mapping.count_start
    if start is None:
        return counted + fraction_seconds
    clock = counted + (start - epoch).total_seconds()
    return convert_calendar_seconds(epoch, clock + fraction_seconds, mapping.time_scale)


def _parse_stamps(stamps: pd.Series, epoch: datetime, time_scale: str) -> Floats:
    """Convert ISO 8601 times to SI seconds since the epoch. Invalid times become NaN."""
    offsets = stamps.str.extract(_UTC_OFFSET)
    ahead = 3600.0 * offsets[1].astype(float) + 60.0 * offsets[2].astype(float)
    ahead = ahead.where(offsets[0] != "-", -ahead).fillna(0.0)
    clocks = stamps.str.replace(_UTC_OFFSET, "", regex=True).tolist()
    try:
        result = parse_time_stamps(epoch, clocks, time_scale)
    except ValueError:
        result = np.array([_parse_stamp(clock, epoch, time_scale) for clock in clocks])
    return result - ahead.to_numpy()


def _parse_stamp(stamp: str, epoch: datetime, time_scale: str) -> float:
    try:
        return float(parse_time_stamps(epoch, [stamp], time_scale)[0])
    except ValueError:
        return np.nan
