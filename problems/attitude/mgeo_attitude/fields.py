"""Dataclass fields that know their meaning, unit and range, and check themselves.

One declaration refuses bad values, in a message that names them, and comments scenario files::

    eccentricity: float = quantity(doc="orbit eccentricity", low=0.0, high=1.0, open_high=True)
    # InvalidValue: eccentricity = 1.2: expected a number in [0, 1) (orbit eccentricity)
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import MISSING, dataclass
from numbers import Integral, Real
from types import NoneType, UnionType
from typing import Any, Union, get_args, get_origin, get_type_hints


class InvalidValue(ValueError):
    """A value that a field refuses: ``key``, ``value``, and what was ``expected`` instead."""

    def __init__(self, key: str, value: object, expected: str) -> None:
        super().__init__(key, value, expected)
        self.key, self.value, self.expected = key, value, expected

    def __str__(self) -> str:
        return f"{self.key} = {self.value!r}: {self.expected}"

    def under(self, section: str) -> InvalidValue:
        """The same error with its key inside `section`: ``a`` becomes ``section.a``."""
        return type(self)(f"{section}.{self.key}", self.value, self.expected)


class InvalidType(InvalidValue, TypeError):
    """A value of the wrong type."""


@dataclass(frozen=True)
class Quantity:
    """What a field holds: its meaning, unit, and allowed range (numbers) or choices (strings)."""

    doc: str = ""
    unit: str = ""
    low: float = -math.inf
    high: float = math.inf
    open_low: bool = False
    open_high: bool = False
    choices: tuple[str, ...] = ()

    def allows(self, number: float) -> bool:
        """Whether a number is finite and in the range."""
        above = number > self.low if self.open_low else number >= self.low
        below = number < self.high if self.open_high else number <= self.high
        return -math.inf < number < math.inf and above and below

    def range_text(self) -> str:
        """The range as a person writes it: ``in [0, 1)``, ``> 0 m``, ``in nT`` (any)."""
        unit = f" {self.unit}" if self.unit else ""
        if math.isfinite(self.low) and math.isfinite(self.high):
            left, right = "(" if self.open_low else "[", ")" if self.open_high else "]"
            return f"in {left}{self.low:.12g}, {self.high:.12g}{right}{unit}"
        if math.isfinite(self.low):
            return f"{'>' if self.open_low else '>='} {self.low:.12g}{unit}"
        if math.isfinite(self.high):
            return f"{'<' if self.open_high else '<='} {self.high:.12g}{unit}"
        return f"in{unit}" if unit else ""


def quantity(default: Any = MISSING, **declaration: Any) -> Any:
    """A dataclass field carrying a `Quantity`, whose attributes are the keywords."""
    return dataclasses.field(default=default, metadata={"quantity": Quantity(**declaration)})


class Validated:
    """Base of frozen dataclasses whose fields are checked by annotation and `quantity`.

    Understood annotations: float (takes any real number), int, bool, str, tuples of these (taking
    lists), classes or unions of classes, and any of these or None. A bool is never a number;
    numbers are finite; a range holds for every entry of a tuple. A subclass that checks more
    extends ``__post_init__``.

    Raises
    ------
    InvalidType, InvalidValue
        (TypeError, ValueError) Naming the field, its value and what was expected.
    """

    def __post_init__(self) -> None:
        for name, (annotation, spec) in declared(type(self)).items():
            value = checked(name, getattr(self, name), annotation, spec)
            object.__setattr__(self, name, value)  # the dataclass is frozen for everyone else


def declared(cls: type) -> dict[str, tuple[Any, Quantity]]:
    """Annotation and `Quantity` of each field of a dataclass, in order."""
    hints = get_type_hints(cls)
    return {
        field.name: (hints[field.name], field.metadata.get("quantity", Quantity()))
        for field in dataclasses.fields(cls)
    }


def expectation(annotation: Any, spec: Quantity) -> str:
    """What a field takes, in words: ``expected a number in [0, 1) (orbit eccentricity)``."""
    meaning = f" ({spec.doc})" if spec.doc else ""
    return f"expected {_takes(annotation, spec)}{meaning}"


def checked(key: str, value: Any, annotation: Any, spec: Quantity) -> Any:
    """The value as its annotation wants it (an int as float, a list as tuple), or an error."""
    expected = expectation(annotation, spec)
    optional, annotation = _optional(annotation)
    if optional and value is None:
        return None
    if get_origin(annotation) is tuple:
        entries = get_args(annotation)
        if not isinstance(value, tuple | list):
            raise InvalidType(key, value, expected)
        if entries[-1] is Ellipsis:
            entries = entries[:1] * len(value)
        elif len(value) != len(entries):
            raise InvalidValue(key, value, expected)
        pairs = enumerate(zip(value, entries, strict=True))
        return tuple(checked(f"{key}[{i}]", entry, kind, spec) for i, (entry, kind) in pairs)
    if annotation in (float, int):
        abstract = Real if annotation is float else Integral  # covers numpy's numbers too
        if isinstance(value, bool) or not isinstance(value, abstract):
            raise InvalidType(key, value, expected)
        try:
            number = annotation(value)
        except OverflowError:  # an integer that no float can hold
            raise InvalidValue(key, value, expected) from None
        if not spec.allows(number):
            raise InvalidValue(key, value, expected)
        return number
    if not isinstance(value, _classes(annotation)):
        raise InvalidType(key, value, expected)
    if spec.choices and value not in spec.choices:
        raise InvalidValue(key, value, expected)
    return value


def _optional(annotation: Any) -> tuple[bool, Any]:
    """Whether None is allowed, and the annotation of anything else."""
    kinds = get_args(annotation) if get_origin(annotation) in (Union, UnionType) else ()
    others = tuple(kind for kind in kinds if kind is not NoneType)
    if len(others) == len(kinds):
        return False, annotation
    return True, Union[others]  # noqa: UP007 (of a tuple)


def _takes(annotation: Any, spec: Quantity) -> str:
    optional, annotation = _optional(annotation)
    if optional:
        return f"nothing or {_takes(annotation, spec)}"
    if get_origin(annotation) is tuple:
        entries = get_args(annotation)
        count = "" if entries[-1] is Ellipsis else f"{len(entries)} x "
        return f"a list of {count}({_takes(entries[0], spec)})"
    if spec.choices:
        return "one of " + ", ".join(map(repr, spec.choices))
    number = "a number" if spec.range_text() else "a finite number"
    known = {float: number, int: "an integer", bool: "true or false", str: "a string"}
    if annotation in known:
        return f"{known[annotation]} {spec.range_text()}".strip()
    return " or ".join(cls.__name__ for cls in _classes(annotation))


def _classes(annotation: Any) -> tuple[type, ...]:
    origin = get_origin(annotation)
    return get_args(annotation) if origin in (Union, UnionType) else (origin or annotation,)
