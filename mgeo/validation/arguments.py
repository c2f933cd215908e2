"""Checks of arguments: each error names the value and what was expected."""

import difflib
import math
import re
from collections.abc import Callable, Collection, Iterable
from numbers import Integral, Real
from typing import Any, TypeVar

import numpy as np

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
    converted = float(value)
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
) -> None:
    """Refuse keywords that nobody reads.

    Parameters
    ----------
    given : the keywords.
    known : those that are read.
    where : they came in.
    others : what the same place takes besides, and has taken already.

    Raises
    ------
    TypeError : naming the first unknown keyword, where it came in, and the likeliest known one.
    """
    for name in given:
        if name not in known:
            expected = sorted({*known, *others})
            raise TypeError(
                f"{where} got an unknown keyword {name!r}{did_you_mean(name, expected)}; known are "
                f"{', '.join(expected)}"
            )


def did_you_mean(value: Any, known: Collection[str]) -> str:
    """The end of a message on a value that looks like known ones; empty where it does not.

    The usual slip is a part of a name: without its unit, or ``bias_nt`` for ``initial_bias_nt``.
    All names are told of which the value is a part, or else the one that is most like it.
    """
    words = _words(value)
    longer = [name for name in known if words and f" {words} " in f" {_words(name)} "]
    close = longer or difflib.get_close_matches(str(value), known, n=1)
    return f"; did you mean {' or '.join(map(repr, close))}?" if close else ""


def _words(name: Any) -> str:
    return " ".join(re.findall(r"[^\W_]+", str(name)))
