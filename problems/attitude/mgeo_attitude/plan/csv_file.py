"""Timelines as CSV, one row per phase, for spreadsheets and flight-procedure tools.

The columns are those of `ManeuverPlan.timeline`, after ``row``, such as 2/4, by which a file that
has lost rows is known. Floats are written by repr, so that they read back exactly.
"""

from __future__ import annotations

import os
import re
from collections.abc import Hashable, Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from ..fields import InvalidValue
from ..files import write_text
from ..phases import HELD
from .plan import ManeuverPlan
from .reading import TOLERANCE, errors_of, parse_csv, parse_number, read_text
from .utc import utc_texts

Floats = NDArray[np.float64]

_NUMBERS = [
    "start [s]",
    "end [s]",
    "duration [s]",
    *(f"rate {axis} [deg/s]" for axis in "xyz"),
    "swept [deg]",
    *(f"{place} q{part}" for place in ("start", "end") for part in "123c"),
]
_COLUMNS = ["row", "phase", *_NUMBERS[:3], "start UTC", "end UTC", *_NUMBERS[3:]]


def to_csv(plan: ManeuverPlan) -> str:
    """The timeline as CSV with a header."""
    table = plan.timeline()
    rows = [f"{i + 1}/{len(table)}" for i in range(len(table))]
    text: str = table.set_axis(rows, axis=0).to_csv(index_label="row", lineterminator="\n")
    return text


def from_csv(text: str) -> pd.DataFrame:
    """The timeline, as `ManeuverPlan.timeline` gives it, from what `to_csv` wrote.

    Raises
    ------
    ValueError
        If a row or column is missing or added, a value is no finite number, or the rows contradict
        themselves or one another; the message names row and column.
    """
    rows = parse_csv(text, _COLUMNS)
    table = pd.DataFrame(rows, columns=_COLUMNS)
    for i, place in enumerate(table.pop("row"), 1):
        _expect(place == f"{i}/{len(rows)}", i, "row", place, f"{i}/{len(rows)}")
    for name in _NUMBERS:
        texts = enumerate(table[name], 1)
        table[name] = [parse_number(f"row {i}, {name}", value) for i, value in texts]
    _check_contents(table)
    return table


def write_csv(plan: ManeuverPlan, path: str | os.PathLike[str]) -> None:
    """Write `to_csv` to a file, whole or not at all."""
    write_text(Path(path), to_csv(plan))


def read_csv(path: str | os.PathLike[str]) -> pd.DataFrame:
    """Read what `write_csv` wrote.

    Raises
    ------
    OSError
        If it cannot be read.
    ValueError
        Naming the file, row and column, see `from_csv`.
    """
    path = Path(path)
    with errors_of(path):
        return from_csv(read_text(path))


def _check_contents(table: pd.DataFrame) -> None:
    """Whether every row follows from the one before, and is one turn at its rates."""
    epoch = _epoch(table["start UTC"].iloc[0])
    end, q = 0.0, table[[f"start q{part}" for part in "123c"]].iloc[0].to_numpy(float)
    for i, row in enumerate(table.to_dict("records"), 1):
        _expect(row["start [s]"] == end, i, "start [s]", row["start [s]"], repr(end))
        _expect(row["end [s]"] > end, i, "end [s]", row["end [s]"], f"more than {end!r}")
        duration, end = row["end [s]"] - end, row["end [s]"]
        _expect(
            row["duration [s]"] == duration, i, "duration [s]", row["duration [s]"], repr(duration)
        )
        rates = np.array([row[f"rate {axis} [deg/s]"] for axis in "xyz"])
        swept = float(np.linalg.norm(rates)) * duration
        close = abs(row["swept [deg]"] - swept) <= TOLERANCE * swept
        _expect(close, i, "swept [deg]", row["swept [deg]"], repr(swept))
        _check_quaternion(i, "start", row, q)
        turn = Rotation.from_rotvec(rates * duration, degrees=True)
        q = (Rotation.from_quat(q) * turn).as_quat()
        _check_quaternion(i, "end", row, q)
        texts = utc_texts(epoch, [row["start [s]"], end])
        for name, expected in zip(("start UTC", "end UTC"), texts, strict=True):
            _expect(row[name] == expected, i, name, row[name], expected)
        label = re.fullmatch(r"maneuver [1-9]\d*", row["phase"]) or row["phase"] == HELD
        _expect(label, i, "phase", row["phase"], f"'maneuver' and a number, or {HELD!r}")


def _check_quaternion(i: int, place: str, row: Mapping[Hashable, Any], expected: Floats) -> None:
    names = [f"{place} q{part}" for part in "123c"]
    found = np.array([row[name] for name in names])
    same_sign = -expected if found @ expected < 0.0 else expected  # of one rotation both are right
    for name, value, number in zip(names, found, same_sign, strict=True):
        _expect(abs(value - number) <= TOLERANCE, i, name, float(value), f"{number:.9f}")


def _epoch(text: str) -> datetime:
    try:
        return datetime.fromisoformat(text).replace(tzinfo=UTC)
    except ValueError:
        _expect(False, 1, "start UTC", text, "a time such as 2018-06-05T00:00:00.000000")
        raise


def _expect(condition: object, i: int, name: str, value: object, expected: str) -> None:
    if not condition:
        raise InvalidValue(f"row {i}, {name}", value, f"expected {expected}")
