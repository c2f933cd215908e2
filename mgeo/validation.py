"""Checks of what a user passes in or a file holds: errors name the value and what was expected."""

import difflib
import math
import os
import sys
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager
from numbers import Integral, Real
from types import MappingProxyType
from typing import Any, TypeVar, get_args, get_origin

import numpy as np

_KINDS: Mapping[Any, str] = {
    str: "a string",
    int: "an integer",
    float: "a finite number",
    bool: "true or false",
    dict: "a table",
    list: "a list",
}

T = TypeVar("T")


def validate_integer(name: str, value: Any, *, low: int, high: int | None = None) -> int:
    """An int of at least `low` and, if that is given, at most `high`.

    Raises
    ------
    TypeError : for anything but an integer (bool included).
    ValueError : if out of range.
    """
    limits = f"of at least {low}" if high is None else f"from {low} to {high:,}"
    if isinstance(value, bool | np.bool_) or not isinstance(value, Integral):
        raise TypeError(f"{name} = {value!r}: expected an integer {limits}")
    converted = int(value)
    if converted < low or (high is not None and converted > high):
        raise ValueError(f"{name} = {value!r}: expected an integer {limits}")
    return converted


def validate_number(
    name: str, value: Any, *, above: float = -math.inf, low: float = -math.inf
) -> float:
    """A finite float, greater than `above` and not less than `low`.

    Raises
    ------
    TypeError : for anything but a real number (bool included).
    ValueError : if out of range.
    """
    expected = f"a finite number {f'> {above:g}' if above > -math.inf else f'>= {low:g}'}"
    if isinstance(value, bool | np.bool_) or not isinstance(value, Real):
        raise TypeError(f"{name} = {value!r}: expected {expected}")
    try:
        converted = float(value)
    except OverflowError:  # an integer that no float can hold
        converted = math.inf
    if not (math.isfinite(converted) and converted > above and converted >= low):
        raise ValueError(f"{name} = {value!r}: expected {expected}")
    return converted


def validate_fraction(name: str, value: Any) -> float:
    """A number in [0, 1]; raises as `validate_number`."""
    if (converted := validate_number(name, value, low=0)) > 1:
        raise ValueError(f"{name} = {value!r}: expected a number in [0, 1]")
    return converted


def validate_each(name: str, value: Any, check: Callable[..., T], **limits: float) -> T | list[T]:
    """One value, or a list of them, each converted and checked by one of these functions."""
    if np.ndim(value) == 0:
        return check(name, value[()] if isinstance(value, np.ndarray) else value, **limits)
    return validate_list(name, value, check, **limits)


def validate_list(
    name: str, value: Iterable[Any], check: Callable[..., T], **limits: float
) -> list[T]:
    """Entries, each converted and checked by one of these functions, under the name ``name[i]``."""
    return [check(f"{name}[{i}]", entry, **limits) for i, entry in enumerate(value)]


def validate_pair(name: str, value: Any, check: Callable[..., T], **limits: float) -> list[T]:
    """Two entries, each converted and checked by one of these functions.

    Raises
    ------
    TypeError : what `check` raises, for `name[0]` or `name[1]`.
    ValueError : likewise, and for anything but two entries.
    """
    if np.shape(value) != (2,):
        raise ValueError(f"{name} = {value!r}: expected two numbers")
    return validate_list(name, value, check, **limits)


def validate_ascending(name: str, value: Any, **limits: float) -> list[float]:
    """Two numbers within limits, the smaller one first.

    Raises
    ------
    TypeError, ValueError : as of `validate_pair`; ValueError also for the larger one first.
    """
    pair = validate_pair(name, value, validate_number, **limits)
    if pair[0] > pair[1]:
        raise ValueError(f"{name} = {value!r}: expected the smaller one first")
    return pair


def validate_choice(name: str, value: Any, choices: Collection[str]) -> str:
    """One of `choices`.

    Raises
    ------
    ValueError : if it is none of them.
    """
    if not isinstance(value, str) or value not in choices:
        known = ", ".join(map(repr, choices))
        raise ValueError(
            f"{name} = {value!r}: expected one of {known}{did_you_mean(value, choices)}"
        )
    return value


def refuse_unknown(
    given: Iterable[str],
    known: Collection[str],
    where: str,
    others: Collection[str] = (),
    instead: Mapping[str, str] = MappingProxyType({}),
) -> None:
    """Refuse keywords that nobody reads.

    Parameters
    ----------
    given : the keywords.
    known : those that are read.
    where : they came in.
    others : what the same place takes besides, and has taken already.
    instead : what to do instead of giving some others.

    Raises
    ------
    TypeError : naming the first unknown keyword, where it came in, and what to do instead or the
        likeliest known one.
    """
    for name in given:
        if name not in known:
            expected = sorted({*known, *others})
            what = f"{did_you_mean(name, expected)}; known are {', '.join(expected)}"
            what = f": {instead[name]}" if name in instead else what
            raise TypeError(f"{where} got an unknown keyword {name!r}{what}")


def did_you_mean(value: Any, known: Collection[str]) -> str:
    """The end of a message on a value that looks like a known one; empty where it does not."""
    close = difflib.get_close_matches(str(value), known, n=1)
    return f"; did you mean {close[0]!r}?" if close else ""


class FileError(ValueError):
    """A file that does not hold what it should; the message says which, what and where."""


@contextmanager
def errors_of(path: str | os.PathLike[str]) -> Iterator[None]:
    """Make a `FileError` of any ValueError or TypeError: with the file's name before it."""
    try:
        yield
    except (ValueError, TypeError) as error:
        raise FileError(f"{os.fspath(path)}: {error}") from error


def entry(table: Any, key: str, kind: Any, where: str = "") -> Any:
    """An entry of a table that was read, which is of the kind expected.

    Parameters
    ----------
    kind
        str, int, float (finite; also an int), bool, list, dict, or of these ``list[str]``,
        ``dict[str, int]``, and so on.
    where
        What the table is called in messages, such as ``"hypervolume."``.

    Raises
    ------
    ValueError
        If it is missing.
    TypeError
        If it is of another kind.
    """
    if not isinstance(table, Mapping):
        raise TypeError(f"{where.rstrip('.') or 'the content'} = {table!r:.80}: expected a table")
    if key not in table:
        raise ValueError(f"{where}{key} is missing: expected {_expected(kind)}")
    if not _is(table[key], kind):
        raise TypeError(f"{where}{key} = {table[key]!r:.80}: expected {_expected(kind)}")
    return table[key]


def _is(value: Any, kind: Any) -> bool:
    base = get_origin(kind) or kind
    if base is float:
        number = isinstance(value, int | float) and not isinstance(value, bool)
        return number and abs(value) <= sys.float_info.max
    if not isinstance(value, base) or (base is int and isinstance(value, bool)):
        return False
    entries = value.values() if base is dict else value if base is list else ()
    return all(_is(each, get_args(kind)[-1]) for each in entries) if get_args(kind) else True


def _expected(kind: Any) -> str:
    base = get_origin(kind)
    if base is None:
        return _KINDS[kind]
    return f"{_KINDS[base]}, each entry {_expected(get_args(kind)[-1])}"
