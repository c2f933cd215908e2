"""Columns of a table: finding them by name, and their numbers, times and units."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
from mgeo_attitude._typing import Floats
from mgeo_attitude.environment.times import clock_seconds_after, seconds_after
from mgeo_attitude.scenario.scenario import Scenario

from mgeo_calibration.telemetry.mapping import Channels

_NAME_AND_UNIT = re.compile(r"([^\[(]*)[\[(](.*)[\])]")
_UTC_OFFSET = r"([+-])(\d\d):?(\d\d)$"
_SPELLINGS = {"µ": "u", "μ": "u", "°": "deg"}
_SYNONYMS = {"dps": "deg/s", "sec": "s", "none": "-", "1": "-"}
_OTHER_TIMES = ("ms", "us", "min", "h", "d")


@dataclass(frozen=True)
class Column:
    """A column of a table: its position, the sign to multiply its numbers by, and its unit."""

    place: int
    sign: float
    unit: str


def has_columns(frame: pd.DataFrame, wanted: Sequence[str]) -> bool:
    """Return whether the table has one of the wanted columns."""
    return not {_plain_name(name) for name in frame.columns}.isdisjoint(map(_plain_name, wanted))


def find_columns(frame: pd.DataFrame, wanted: Sequence[str]) -> dict[str, Column]:
    """Find the wanted columns.

    Names differ neither by case nor by a unit in brackets; a minus before a name negates it.

    Raises
    ------
    ValueError
        For missing or ambiguous columns, or an empty table.
    """
    names = [str(name) for name in frame.columns]
    plain = [_plain_name(name) for name in names]
    found, missing = dict[str, Column](), []
    for name in wanted:
        sign = -1.0 if name.startswith("-") and name not in names else 1.0
        bare = name[1:].strip() if sign < 0.0 else name
        places = [k for k, each in enumerate(names) if each == bare]
        places = places or [k for k, each in enumerate(plain) if each == _plain_name(bare)]
        if len(places) > 1 or any(k == other.place for k in places for other in found.values()):
            raise ValueError(f"column {bare!r} is there, or asked for, twice")
        for k in places:
            found[name] = Column(k, sign, name_and_unit(names[k])[1])
        missing += [] if places else [bare]
    if missing:
        raise ValueError(f"missing columns {', '.join(missing)}: there are {', '.join(names)}")
    if frame.empty:
        raise ValueError("there are no rows")
    return found


def name_and_unit(name: object) -> tuple[str, str]:
    """Split a column's name into the bare name and the unit in brackets at its end."""
    text = str(name).strip()
    parts = _NAME_AND_UNIT.fullmatch(text)
    return (parts[1].strip(), parts[2].strip()) if parts else (text, "")


def _plain_name(name: object) -> str:
    return name_and_unit(name)[0].casefold()


def with_unit(name: str, entry: Channels, columns: Sequence[Column]) -> Channels:
    """Return the mapping's entry with the unit of its columns, unless it has one."""
    units = {column.unit for column in columns}
    if entry.unit is not None or units <= {""}:
        return entry
    if len(units) > 1:
        raise ValueError(f"{name}: columns in {', '.join(sorted(units))}: expected one unit")
    (unit,) = units
    for sign, known in _SPELLINGS.items():
        unit = unit.replace(sign, known)
    return replace(entry, unit=_SYNONYMS.get(unit, unit))


def numbers(column: pd.Series) -> Floats:
    """Return a column as floats, NaN where it is empty.

    Raises
    ------
    ValueError
        Naming row and column of a cell that is no finite number.
    """
    values: Floats = _numeric(column).to_numpy(dtype=float, na_value=np.nan)
    wrong = np.isinf(values)
    if column.dtype.kind not in "iuf":
        wrong |= np.isnan(values) & column.notna().to_numpy() & (column != "").to_numpy(bool)
    if wrong.any():
        row = int(np.argmax(wrong))
        raise ValueError(
            f"row {row + 1}, {column.name} = {_shown(column.iloc[row])}: expected a number"
        )
    return values


def channel_of(columns: Iterable[str], name: str) -> str | None:
    """Return the column of this name, whatever its case and unit; None if there is none."""
    return next((each for each in columns if _plain_name(each) == _plain_name(name)), None)


def other_columns(
    frame: pd.DataFrame, used: Collection[int], wanted: Collection[str] = ()
) -> dict[str, Floats]:
    """Return the unused columns of numbers that vary and are mostly filled, by name.

    Wanted columns need only one number.
    """
    asked = {_plain_name(name) for name in wanted}
    found = {}
    for place, name in enumerate(frame.columns):
        column = frame.iloc[:, place]
        if place in used or column.dtype.kind in "mM":
            continue
        try:
            values = numbers(column)
        except ValueError:
            continue
        there = np.isfinite(values)
        varies = 2 * there.sum() > len(values) and np.ptp(values[there]) > 0.0
        if there.any() if _plain_name(name) in asked else varies:
            found[str(name)] = values
    return found


def seconds(column: pd.Series, form: str, scenario: Scenario) -> Floats:
    """Return SI seconds since the epoch of numbers, time stamps or ISO 8601 texts.

    Raises
    ------
    ValueError
        Naming the row and value of what is no time.
    """
    epoch, name = scenario.epoch, str(column.name)
    if name_and_unit(name)[1] in _OTHER_TIMES and form != "unix-ms":
        raise ValueError(f"{name}: expected seconds since the epoch, Unix times or ISO 8601")
    if column.dtype.kind == "O" and _numeric(column.iloc[:1]).notna().all():
        column = pd.Series(numbers(column), name=name)
    times: Floats
    if column.dtype.kind in "iuf":
        times = numbers(column)
        if form != "epoch":
            unix = times * (1e-3 if form == "unix-ms" else 1.0)
            times = clock_seconds_after(epoch, unix - epoch.timestamp())
    elif form != "epoch":
        first = _shown(column.iloc[0])
        raise ValueError(f"row 1, {name} = {first}: expected {form} times, as time_format says")
    elif column.dtype.kind == "M":
        clock = (pd.to_datetime(column, utc=True) - pd.Timestamp(epoch)).dt.total_seconds()
        times = clock_seconds_after(epoch, clock.to_numpy(dtype=float))
    else:
        times = _parsed(column.astype(str).str.strip(), scenario)
    if np.isnan(times).any():
        row = int(np.argmax(np.isnan(times)))
        raise ValueError(
            f"row {row + 1}, {name} = {_shown(column.iloc[row])}: expected seconds since the epoch "
            "or a time of ISO 8601"
        )
    return times


def _parsed(stamps: pd.Series, scenario: Scenario) -> Floats:
    """SI seconds since the epoch of ISO 8601 stamps, NaN of what is none."""
    offsets = stamps.str.extract(_UTC_OFFSET)
    ahead = 3600.0 * offsets[1].astype(float) + 60.0 * offsets[2].astype(float)
    ahead = ahead.where(offsets[0] != "-", -ahead).fillna(0.0)
    clocks = stamps.str.replace(_UTC_OFFSET, "", regex=True).tolist()
    try:
        found = seconds_after(scenario.epoch, clocks)
    except ValueError:
        found = np.array([_second(clock, scenario) for clock in clocks])
    return found - ahead.to_numpy()


def _second(stamp: str, scenario: Scenario) -> float:
    try:
        return float(seconds_after(scenario.epoch, [stamp])[0])
    except ValueError:
        return np.nan


def _numeric(column: pd.Series) -> pd.Series:
    return pd.to_numeric(column, errors="coerce")


def _shown(cell: object) -> str:
    return f"{cell.item() if isinstance(cell, np.generic) else cell!r:.40}"
