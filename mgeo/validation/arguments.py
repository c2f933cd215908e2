"""Validation of function arguments; each error message states the value and the expectation."""

import difflib
import math
import re
from collections.abc import Callable, Collection, Iterable
from numbers import Integral, Real
from typing import Any, TypeVar

import numpy as np

T = TypeVar("T")


def validate_integer(name: str, value: Any, *, low: int, high: int | None = None) -> int:
    """Check that an argument is an integer in a given range, and return it as an int.

    Parameters
    ----------
    name : str
        Name of the argument, for the message.
    value : int or NumPy integer
    low : int
        Smallest allowed value.
    high : int, optional
        Largest allowed value.

    Raises
    ------
    TypeError
        If the value is not an integer. A bool is not accepted.
    ValueError
        If the value is out of range.
    """
    allowed = f"of at least {low}" if high is None else f"from {low} to {high:,}"
    if isinstance(value, bool | np.bool_) or not isinstance(value, Integral):
        raise TypeError(f"{name} = {value!r}: expected an integer {allowed}")
    converted = int(value)
    if converted < low or (high is not None and converted > high):
        raise ValueError(f"{name} = {value!r}: expected an integer {allowed}")
    return converted


def validate_number(
    name: str, value: Any, *, above: float = -math.inf, low: float = -math.inf
) -> float:
    """Check that an argument is a finite number in a given range, and return it as a float.

    Parameters
    ----------
    name : str
        Name of the argument, for the message.
    value : int, float or NumPy number
    above : float
        Exclusive lower bound.
    low : float
        Inclusive lower bound.

    Raises
    ------
    TypeError
        If the value is not a real number. A bool is not accepted.
    ValueError
        If the value is not finite or out of range.
    """
    expected = f"a finite number {f'> {above:g}' if above > -math.inf else f'>= {low:g}'}"
    if isinstance(value, bool | np.bool_) or not isinstance(value, Real):
        raise TypeError(f"{name} = {value!r}: expected {expected}")
    converted = float(value)
    if not (math.isfinite(converted) and converted > above and converted >= low):
        raise ValueError(f"{name} = {value!r}: expected {expected}")
    return converted


def validate_fraction(name: str, value: Any) -> float:
    """Check that an argument is a number in [0, 1], and return it as a float.

    Errors are as for `validate_number`.
    """
    if (converted := validate_number(name, value, low=0)) > 1:
        raise ValueError(f"{name} = {value!r}: expected a number in [0, 1]")
    return converted


def validate_each(name: str, value: Any, check: Callable[..., T], **limits: float) -> T | list[T]:
    """Check an argument that may be a single number or a list of numbers.

    Parameters
    ----------
    name : str
        Name of the argument, for the message.
    value : number, list or array
    check : function
        Function of this module that validates a single number, such as `validate_number`.
    **limits
        Keywords of `check`.

    Returns
    -------
    number or list
        Return value of `check`, or a list of them.
    """
    if np.ndim(value) == 0:
        return check(name, value[()] if isinstance(value, np.ndarray) else value, **limits)
    return validate_list(name, value, check, **limits)


def validate_list(
    name: str, value: Iterable[Any], check: Callable[..., T], **limits: float
) -> list[T]:
    """Check each entry of a list, and return the list of checked entries.

    Parameters
    ----------
    name : str
        Name of the list. Messages call entry i ``name[i]``.
    value : iterable
    check : function
        Function of this module that validates a single entry, such as `validate_number`.
    **limits
        Keywords of `check`.
    """
    return [check(f"{name}[{i}]", entry, **limits) for i, entry in enumerate(value)]


def validate_pair(name: str, value: Any, check: Callable[..., T], **limits: float) -> list[T]:
    """Check that an argument is a pair of valid values, and return it as a list.

    Parameters are as for `validate_list`.

    Raises
    ------
    TypeError
        If an entry has the wrong type.
    ValueError
        If there are not exactly two entries, or an entry is out of range.
    """
    if np.shape(value) != (2,):
        raise ValueError(f"{name} = {value!r}: expected two numbers")
    return validate_list(name, value, check, **limits)


def validate_choice(name: str, value: Any, choices: Collection[str]) -> str:
    """Check that an argument is one of the allowed strings, and return it.

    Raises
    ------
    ValueError
        If the value is not one of `choices`. The message suggests a similar choice.
    """
    if not isinstance(value, str) or value not in choices:
        listed = ", ".join(map(repr, choices))
        raise ValueError(
            f"{name} = {value!r}: expected one of {listed}{format_suggestion(value, choices)}"
        )
    return value


def reject_unknown_keywords(
    keywords: Iterable[str],
    known: Collection[str],
    where: str,
    other_keywords: Collection[str] = (),
) -> None:
    """Raise TypeError for an unknown keyword, and suggest a similar one.

    Parameters
    ----------
    keywords : iterable of str
        Keywords to check.
    known : collection of str
        Allowed keywords.
    where : str
        Callable that received the keywords, for the message.
    other_keywords : collection of str
        Further keywords of the callable. They appear in the message, but not in `keywords`.
    """
    for name in keywords:
        if name not in known:
            expected = sorted({*known, *other_keywords})
            raise TypeError(
                f"{where} got an unknown keyword {name!r}{format_suggestion(name, expected)}; "
                f"expected one of {', '.join(expected)}"
            )


def format_suggestion(value: Any, known: Collection[str]) -> str:
    """Return the suffix "; did you mean ...?" for an error message about an unknown name.

    Parameters
    ----------
    value : object
        The unknown name.
    known : collection of str
        The known names.

    Returns
    -------
    str
        Text with all known names that contain the words of `value`, such as ``initial_bias_nt``
        for ``bias_nt``. If there are none, the last of three or more words, usually a unit, is
        ignored: ``initial_bias_deg_s`` for ``bias_deg_h``. Otherwise the text has the most similar
        name; it is empty if no name is similar.
    """
    words = _join_words(value)
    quantity = words.rpartition(" ")[0] if words.count(" ") > 1 else ""
    close = (
        _find_containing(words, known)
        or _find_containing(quantity, known)
        or difflib.get_close_matches(str(value), known, n=1)
    )
    return f"; did you mean {' or '.join(map(repr, close))}?" if close else ""


def _find_containing(words: str, known: Collection[str]) -> list[str]:
    return [name for name in known if words and f" {words} " in f" {_join_words(name)} "]


def _join_words(name: Any) -> str:
    """Return the words of a name, separated by single spaces."""
    return " ".join(re.findall(r"[^\W_]+", str(name)))
