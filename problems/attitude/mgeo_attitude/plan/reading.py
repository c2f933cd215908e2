"""Reading of files that somebody else may have written: bounded, plain data, clear errors."""

from __future__ import annotations

import csv
import io
import json
import math
import os
import re
import stat
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from ..fields import InvalidType, InvalidValue

#: A front of 10,000 plans, or a plan of 100 maneuvers, is far smaller.
MOST_BYTES = 64 * 2**20

_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?", re.ASCII | re.IGNORECASE)

#: Numbers that were computed again, perhaps by other libraries, may differ by this fraction.
TOLERANCE = 1e-6


@contextmanager
def errors_of(path: Path) -> Iterator[None]:
    """Put the file's name before the message of any ValueError, and make one of a TypeError."""
    try:
        yield
    except (ValueError, TypeError) as error:
        raise ValueError(f"{path}: {error}") from error


def read_text(path: Path) -> str:
    """Content of a file in UTF-8.

    Raises
    ------
    OSError
        If it cannot be read.
    ValueError
        If it is no regular file, no UTF-8, or larger than `MOST_BYTES`.
    """
    # without waiting for somebody who writes into a pipe
    with open(os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0)), "rb") as file:
        if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
            raise ValueError("a folder, a pipe or a device: expected a file")
        content = file.read(MOST_BYTES + 1)
    if len(content) > MOST_BYTES:
        raise ValueError(f"larger than {MOST_BYTES} bytes: no file of ours")
    return content.decode("utf-8")


def parse_json(text: str) -> Any:
    """Data of strict JSON: no NaN or infinity, no key twice in an object.

    Raises
    ------
    ValueError
        Saying what is wrong and where.
    """
    try:
        return json.loads(text, parse_constant=_no_constant, object_pairs_hook=_unique)
    except RecursionError:
        raise ValueError("nested too deeply") from None


def parse_csv(text: str, columns: Sequence[str]) -> list[list[str]]:
    """Rows of a CSV file with a header, at least one, each with a cell for every column.

    Raises
    ------
    ValueError
        For other columns than the expected, in their order, no row, a row of another length or one
        without an end of line.
    """
    try:
        header, *rows = csv.reader(io.StringIO(text), strict=True) if text else [list[str]()]
    except csv.Error as error:
        raise ValueError(f"no CSV: {error}") from None
    if header != list(columns):
        raise ValueError(f"columns {header}: expected {list(columns)}")
    if not rows or not text.endswith("\n"):
        raise ValueError("expected at least one row below the header, each with its end of line")
    for i, row in enumerate(rows, 1):
        if len(row) != len(header):
            raise ValueError(f"row {i} has {len(row)} values: expected {len(header)}")
    return rows


def parse_number(key: str, text: str) -> float:
    """A finite number, or an error naming the key."""
    # Python also reads 1_0 as a number, and digits of other scripts
    number = float(text) if _NUMBER.fullmatch(text) else math.nan
    if not math.isfinite(number):
        raise InvalidValue(key, text, "expected a finite number")
    return number


def checked_keys(key: str, table: Any, expected: Mapping[str, type | tuple[type, ...]]) -> Any:
    """A table that has just the expected keys, each of its type, or an error naming the key."""
    if not isinstance(table, dict):
        raise InvalidType(key, table, "expected an object")
    place = f"{key}." if key else ""
    for name in table:
        if name not in expected:
            raise InvalidValue(f"{place}{name}", table[name], f"expected {', '.join(expected)}")
    for name, kind in expected.items():
        if name not in table:
            raise ValueError(f"{place}{name} is missing")
        if not isinstance(table[name], kind) or (kind is not bool and table[name] is True):
            raise InvalidType(f"{place}{name}", table[name], "expected another type")
    return table


def check_same(key: str, found: Any, expected: Any) -> None:
    """Whether data read is what it should be: numbers within `TOLERANCE`, the rest equal.

    Raises
    ------
    InvalidValue
        Naming the first key that differs.
    """
    if isinstance(expected, dict) and isinstance(found, dict) and found.keys() == expected.keys():
        for name in expected:
            check_same(f"{key}.{name}", found[name], expected[name])
    elif isinstance(expected, list) and isinstance(found, list) and len(found) == len(expected):
        for i, (one, other) in enumerate(zip(found, expected, strict=True)):
            check_same(f"{key}[{i}]", one, other)
    elif isinstance(expected, float) and type(found) in (int, float):
        # no fraction of a number that is zero but for rounding, as in a quaternion
        close = TOLERANCE * max(abs(expected), TOLERANCE)
        if not expected - close <= found <= expected + close:
            raise InvalidValue(key, found, f"expected {expected!r}, which follows from the design")
    elif type(found) is not type(expected) or found != expected:
        raise InvalidValue(key, found, f"expected {expected!r}, which follows from the design")


def _no_constant(name: str) -> Any:
    raise ValueError(f"{name} is no JSON number")


def _unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    table = dict(pairs)
    if len(table) != len(pairs):
        names = [name for name, _ in pairs]
        twice = next(name for name in names if names.count(name) > 1)
        raise ValueError(f"{twice!r} occurs twice in an object")
    return table
