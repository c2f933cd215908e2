"""Validation of entries of TOML and JSON files; error messages state file, place and value."""

from __future__ import annotations

import json
import os
import sys
import tomllib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any, get_args, get_origin

_EXPECTED: Mapping[Any, str] = {
    str: "a string",
    bool: "true or false",
    int: "an integer",
    float: "a finite number",
    list: "a list",
    dict: "a table",
}


class FileError(ValueError):
    """Error raised for a file with invalid content.

    The message states file, place and value.
    """


@contextmanager
def convert_file_errors(path: str | os.PathLike[str]) -> Iterator[None]:
    """Context manager that converts ValueError and TypeError to a FileError with the file name."""
    try:
        yield
    except (ValueError, TypeError) as error:
        names = {tomllib.TOMLDecodeError: "TOML", json.JSONDecodeError: "JSON"}
        syntax = f"not valid {names[type(error)]}: " if type(error) in names else ""
        raise FileError(f"{os.fspath(path)}: {syntax}{error}") from error


def get_entry(table: Any, key: str, kind: Any, where: str = "") -> Any:
    """Return an entry of a TOML table or JSON object, after checking its type.

    Parameters
    ----------
    table : mapping
        Table or object.
    key : str
        Key of the entry.
    kind : type
        Expected type: str, bool, int, float (finite; ints are accepted), list, dict, Any, or
        ``list[...]`` and ``dict[str, ...]`` of these.
    where : str
        Prefix of the key in messages, such as ``"hypervolume."``.

    Raises
    ------
    ValueError
        If the entry is missing.
    TypeError
        If `table` is not a mapping, or the entry has another type.
    """
    if not isinstance(table, Mapping):
        raise TypeError(f"{where.rstrip('.') or 'the content'} = {table!r:.80}: expected a table")
    if key not in table:
        raise ValueError(f"{where}{key} is missing")
    _check_type(table[key], kind, f"{where}{key}")
    return table[key]


def _check_type(value: Any, kind: Any, where: str) -> None:
    base, parts = get_origin(kind) or kind, get_args(kind)
    if base is Any:
        return
    if base is float:
        is_valid = isinstance(value, int | float) and abs(value) <= sys.float_info.max
    else:
        is_valid = isinstance(value, base)
    if not is_valid or (isinstance(value, bool) and base is not bool):
        expected = _EXPECTED.get(base, getattr(base, "__name__", str(base)))
        raise TypeError(f"{where} = {value!r:.80}: expected {expected}")
    if parts and base is list:
        for i, each in enumerate(value):
            _check_type(each, parts[0], f"{where}[{i}]")
    elif parts and base is dict:
        for name, each in value.items():
            _check_type(each, parts[1], f"{where}.{name}")
