"""Columns of a telemetry table: search by name, conversion of cells, and units."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
import pandas as pd
from mgeo_attitude._typing import Floats
from mgeo_attitude.sensors.suite import Suite
from mgeo_attitude.settings.errors import InvalidValue, format_known_names

from mgeo_calibration.telemetry.mapping import Channels

_NAME_AND_UNIT = re.compile(r"([^\[(]*)[\[(](.*)[\])]")
_SPELLINGS = {"µ": "u", "μ": "u", "°": "deg"}
_SYNONYMS = {"dps": "deg/s", "sec": "s", "none": "-", "1": "-"}


T = TypeVar("T", bound=Channels)


@dataclass(frozen=True)
class Column:
    """Index, sign and unit of a column in a telemetry table. The sign is -1 if the mapping negates
    the values.
    """

    index: int
    sign: float
    unit: str


def has_columns(frame: pd.DataFrame, required: Sequence[str]) -> bool:
    return not {_normalize_name(name) for name in frame.columns}.isdisjoint(
        map(_normalize_name, required)
    )


def find_columns(frame: pd.DataFrame, required: Sequence[str]) -> dict[str, Column]:
    """Find the required columns of a table. Return a dict that maps each required name to its
    column.

    Names are compared without case and without a unit in brackets. A minus before a required name
    negates the values.

    Raises
    ------
    ValueError
        If a column is missing or ambiguous, or the table is empty.
    """
    names = [str(name) for name in frame.columns]
    plain = [_normalize_name(name) for name in names]
    result, missing = dict[str, Column](), []
    for name in required:
        sign = -1.0 if name.startswith("-") and name not in names else 1.0
        bare = name[1:].strip() if sign < 0.0 else name
        indices = [k for k, each in enumerate(names) if each == bare]
        indices = indices or [k for k, each in enumerate(plain) if each == _normalize_name(bare)]
        if len(indices) > 1 or any(k == other.index for k in indices for other in result.values()):
            raise ValueError(
                f"column {bare!r} occurs, or is declared, more than once: expected it once. "
                "Rename or remove one of them"
            )
        for k in indices:
            result[name] = Column(k, sign, split_name_and_unit(names[k])[1])
        missing += [] if indices else [bare]
    if missing:
        raise ValueError(
            f"missing columns {', '.join(missing)}: the table has the columns {', '.join(names)}. "
            "Rename the columns, or declare their names in the mapping"
        )
    if frame.empty:
        raise ValueError("the table has no rows: expected at least one")
    return result


def split_name_and_unit(name: object) -> tuple[str, str]:
    """Split a column name such as ``gyro_x [deg/s]`` into name and unit."""
    text = str(name).strip()
    parts = _NAME_AND_UNIT.fullmatch(text)
    return (parts[1].strip(), parts[2].strip()) if parts else (text, "")


def _normalize_name(name: object) -> str:
    return split_name_and_unit(name)[0].casefold()


def assign_unit(name: str, entry: T, columns: Sequence[Column]) -> T:
    """Add the unit in the column names, such as ``[deg/s]``, to a mapping entry that declares no
    unit, and return the entry.

    Raises
    ------
    ValueError
        If the columns have different units.
    """
    units = {column.unit for column in columns}
    if entry.unit is not None or units <= {""}:
        return entry
    if len(units) > 1:
        raise ValueError(f"{name}: columns in {', '.join(sorted(units))}: expected one unit")
    (unit,) = units
    return replace(entry, unit=normalize_unit(unit))


def normalize_unit(unit: str) -> str:
    """Normalize the spelling of a unit. For example, ``°/s`` and ``dps`` become ``deg/s``."""
    for sign, known in _SPELLINGS.items():
        unit = unit.replace(sign, known)
    return _SYNONYMS.get(unit, unit)


def parse_numbers(column: pd.Series) -> Floats:
    """Convert the cells of a column to floats. Empty cells become NaN.

    Raises
    ------
    ValueError
        With row and column of a cell that is not a finite number.
    """
    values: Floats = convert_to_numeric(column).to_numpy(dtype=float, na_value=np.nan)
    wrong = np.isinf(values)
    if column.dtype.kind not in "iuf":
        wrong |= np.isnan(values) & column.notna().to_numpy() & (column != "").to_numpy(bool)
    if wrong.any():
        row = int(np.argmax(wrong))
        raise ValueError(
            f"row {row + 1}, {column.name} = {format_cell(column.iloc[row])}: expected a number, "
            "or an empty cell"
        )
    return values


def find_channel(columns: Iterable[str], name: str) -> str | None:
    """Return the first column name that matches a channel name, ignoring case and unit. Return None
    if there is no match.
    """
    return next((each for each in columns if _normalize_name(each) == _normalize_name(name)), None)


def find_sensitivity_channels(
    suite: Suite, housekeeping: Mapping[str, Floats]
) -> dict[str, Floats]:
    """Return the housekeeping channels that the bias sensitivities of a suite require, keyed by
    channel name.

    Raises
    ------
    InvalidValue
        With the bias sensitivity whose channel is missing.
    """
    result = {}
    for key, sensitivity in suite.sensitivities_by_key.items():
        name = find_channel(housekeeping, sensitivity.channel)
        if name is None:
            hint = (
                format_known_names(sensitivity.channel, housekeeping)
                if housekeeping
                else ", which has no other columns"
            )
            way = (
                ". Add a column of this name to the telemetry, or remove the bias sensitivity from "
                "the scenario"
            )
            expected = f"expected a column of the telemetry{hint}{way}"
            raise InvalidValue(f"{key}.channel", sensitivity.channel, expected)
        result[sensitivity.channel] = housekeeping[name]
    return result


def select_housekeeping(
    frame: pd.DataFrame, used_indices: Collection[int], required: Collection[str] = ()
) -> dict[str, Floats]:
    """Return the numeric columns of a table that contain no gyro, sensor or position data, keyed by
    name.

    A column must vary and be mostly filled. A required column needs only one value.
    """
    required_names = {_normalize_name(name) for name in required}
    result = {}
    for place, name in enumerate(frame.columns):
        column = frame.iloc[:, place]
        if place in used_indices or column.dtype.kind in "mM":
            continue
        try:
            values = parse_numbers(column)
        except ValueError:
            continue
        has_value = np.isfinite(values)
        varies = 2 * has_value.sum() > len(values) and np.ptp(values[has_value]) > 0.0
        if has_value.any() if _normalize_name(name) in required_names else varies:
            result[str(name)] = values
    return result


def convert_to_numeric(column: pd.Series) -> pd.Series:
    return pd.to_numeric(column, errors="coerce")


def format_cell(cell: object) -> str:
    return f"{cell.item() if isinstance(cell, np.generic) else cell!r:.40}"
