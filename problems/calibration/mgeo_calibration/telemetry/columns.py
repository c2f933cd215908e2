"""Columns of a table by their names, and their cells as numbers and times."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd
from mgeo_attitude._typing import Floats
from mgeo_attitude.environment.times import clock_seconds_after, seconds_after
from mgeo_attitude.scenario.scenario import Scenario

from mgeo_calibration.telemetry.files import MISSING
from mgeo_calibration.telemetry.mapping import Channels

#: Offsets are looked for at the end alone: from the front one pattern for all takes squared time.
_CLOCK, _OFFSET = re.compile(r"\d\d:\d\d"), re.compile(r"([+-])(\d\d):?(\d\d)\Z")
_LONGEST = len("+00:00")
_OTHER_SIGNS = {"µ": "u", "μ": "u", "°": "deg"}
_OTHER_NAMES = {"dps": "deg/s", "sec": "s", "none": "-", "1": "-"}
_OTHER_TIMES = ("ms", "us", "min", "h", "d")


@dataclass(frozen=True)
class Column:
    """One that is there: its place, what makes of its numbers what is asked for, and its unit."""

    place: int
    sign: float
    unit: str


def has_columns(frame: pd.DataFrame, wanted: Sequence[str]) -> bool:
    """Whether there is one of those."""
    return not {_plain_name(name) for name in frame.columns}.isdisjoint(map(_plain_name, wanted))


def find_columns(frame: pd.DataFrame, wanted: Sequence[str]) -> dict[str, Column]:
    """Those that are wanted, by the names that they are asked for by."""
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
    """A name, and the unit in brackets at its end, if there is one."""
    text = str(name).strip()
    opening = min((k for mark in "[(" if (k := text.find(mark)) >= 0), default=-1)
    if opening < 0 or text[-1] not in "])":
        return text, ""
    return text[:opening].strip(), text[opening + 1 : -1].strip()


def _plain_name(name: object) -> str:
    return name_and_unit(name)[0].casefold()


def with_unit(name: str, entry: Channels, columns: Sequence[Column]) -> Channels:
    """The entry with the unit of its columns, if it says none itself."""
    units = {column.unit for column in columns}
    if entry.unit is not None or units <= {""}:
        return entry
    if len(units) > 1:
        raise ValueError(f"{name}: columns in {', '.join(sorted(units))}: expected one unit")
    (unit,) = units
    for sign, known in _OTHER_SIGNS.items():
        unit = unit.replace(sign, known)
    return replace(entry, unit=_OTHER_NAMES.get(unit, unit))


def numbers(column: pd.Series) -> Floats:
    """A column as floats, NaN where it is empty."""
    if column.dtype.kind in "iuf":
        values: Floats = column.to_numpy(dtype=float, na_value=np.nan)
    else:
        values = np.asarray([*map(_number, column)], dtype=np.float64)
    if np.isinf(values).any():
        row = int(np.argmax(np.isinf(values)))
        name = f"row {row + 1}, {column.name} = {_shown(column.iloc[row])}"
        raise ValueError(f"{name}: expected a number")
    return values


def channel_of(columns: Iterable[str], name: str) -> str | None:
    """The name among those of columns that is this but for case and a unit; None if none is."""
    return next((each for each in columns if _plain_name(each) == _plain_name(name)), None)


def other_columns(
    frame: pd.DataFrame, used: Collection[int], wanted: Collection[str] = ()
) -> dict[str, Floats]:
    """Columns of numbers at other places, by their names, that change and are mostly there.

    Those that are `wanted` need neither; there has to be a number in them.
    """
    asked = {_plain_name(name) for name in wanted}
    found = {}
    for place, name in enumerate(frame.columns):
        if place in used:
            continue
        try:
            values = numbers(frame.iloc[:, place])
        except (ValueError, TypeError):
            continue
        there = np.isfinite(values)
        if _plain_name(name) in asked:
            if there.any():
                found[str(name)] = values
            continue
        if 2 * there.sum() > len(values) and np.ptp(values[there]) > 0.0:
            found[str(name)] = values
    return found


def _number(cell: object) -> float:
    """A cell's number, NaN if it is empty, an infinity for anything else."""
    if isinstance(cell, str):
        text = cell.strip()
        if text.lower() in MISSING:
            return math.nan
        if not text.isascii() or "_" in text:  # Python would take 1_0 and digits of other scripts
            return math.inf
        try:
            return float(text)
        except ValueError:
            return math.inf
    if cell is None or cell is pd.NA or cell is pd.NaT:
        return math.nan
    is_number = isinstance(cell, int | float | np.number) and not isinstance(cell, bool)
    return float(cell) if is_number else math.inf  # type: ignore[arg-type]


def _shown(cell: Any) -> str:
    plain = cell.item() if isinstance(cell, np.generic) else cell
    return f"{plain!r:.40}"


def seconds(column: pd.Series, form: str, scenario: Scenario) -> Floats:
    """Seconds of SI since the epoch, of numbers, calendar times or texts of ISO 8601."""
    epoch, name = scenario.epoch, str(column.name)
    times: Floats
    if name_and_unit(name)[1] in _OTHER_TIMES and form != "unix-ms":
        raise ValueError(f"{name}: expected seconds since the epoch, Unix times or ISO 8601")
    if column.dtype.kind not in "iufM" and not math.isinf(_number(column.iloc[0])):
        column = pd.Series(numbers(column), name=name)
    is_number = column.dtype.kind in "iuf"
    if form != "epoch":
        if not is_number:
            first = _shown(column.iloc[0])
            raise ValueError(f"row 1, {name} = {first}: expected {form} times, as time_format says")
        unix = numbers(column) * (1e-3 if form == "unix-ms" else 1.0)
        times = clock_seconds_after(epoch, unix - epoch.timestamp())
    elif is_number:
        times = numbers(column)
    elif column.dtype.kind in "bcm":  # durations, say
        times = np.full(len(column), np.nan)
    elif column.dtype.kind == "M" or not isinstance(column.iloc[0], str):
        at = pd.to_datetime(column, utc=True, errors="coerce")
        clock = (at - pd.Timestamp(epoch)).dt.total_seconds().to_numpy(dtype=float)
        times = clock_seconds_after(epoch, clock)
    else:
        times = _stamped(column.tolist(), scenario)
    if np.isnan(times).any():
        row = int(np.argmax(np.isnan(times)))
        raise ValueError(
            f"row {row + 1}, {name} = {_shown(column.iloc[row])}: expected seconds since the epoch "
            "or a time of ISO 8601"
        )
    return times


def _stamped(texts: list[Any], scenario: Scenario) -> Floats:
    """Seconds of SI since the epoch, NaN of texts that are no time."""
    ahead, stamps = np.zeros(len(texts)), [str(text).strip() for text in texts]
    for k, stamp in enumerate(stamps):
        stamps[k], ahead[k] = _parted(stamp)
    try:
        return seconds_after(scenario.epoch, stamps) - ahead
    except ValueError:
        return np.array([_stamp(stamp, scenario) for stamp in stamps]) - ahead


def _parted(stamp: str) -> tuple[str, float]:
    """A time without its offset from UTC, and this [s]; the end of a date alone is none."""
    offset = _OFFSET.search(stamp, max(0, len(stamp) - _LONGEST))
    clock = stamp[: offset.start()].rsplit(None, 1)[-1:] if offset else []
    if offset is None or not clock or not _CLOCK.search(clock[0]):
        return stamp, 0.0
    sign, hours, minutes = offset.groups()
    size = 3600.0 * int(hours) + 60.0 * int(minutes)
    return stamp[: offset.start()], -size if sign == "-" else size


def _stamp(stamp: str, scenario: Scenario) -> float:
    try:
        return float(seconds_after(scenario.epoch, [stamp])[0])
    except ValueError:
        return math.nan
