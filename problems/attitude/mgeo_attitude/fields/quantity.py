"""What a field holds: its meaning, unit and range, and the errors that refuse anything else."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import MISSING, dataclass
from datetime import datetime
from functools import cache
from types import NoneType, UnionType
from typing import Any, TypeVar, Union, cast, get_args, get_origin, get_type_hints

from mgeo.validation.arguments import did_you_mean


@dataclass(frozen=True)
class Unit:
    """An engineer's unit of a 3-vector of the state; the filter has one of its own."""

    text: str  # as it is shown: deg/h
    suffix: str  # as it ends the names of keys, deg_h; empty for none
    factor: float  # from the filter's unit to this one

    def key(self, name: str) -> str:
        """The key under which a scenario file gives the quantity `name`."""
        return f"{name}_{self.suffix}" if self.suffix else name

    @property
    def key_factor(self) -> float:
        """From the filter's unit to that of the key: a key without a suffix has the filter's."""
        return self.factor if self.suffix else 1.0


DIMENSIONLESS = Unit("-", "", 1.0)
#: Of a part of a unit vector: the angle by which it turns the vector, if it is small.
ARCMIN = Unit("arcmin", "", 60.0 * math.degrees(1.0))
PPM = Unit("ppm", "", 1e6)
SECOND = Unit("s", "s", 1.0)
DEG = Unit("deg", "deg", math.degrees(1.0))
DEG_H = Unit("deg/h", "deg_h", 3600.0 * math.degrees(1.0))


class InvalidValue(ValueError):
    """A value that a field refuses: ``key``, ``value``, and what was ``expected`` instead."""

    def __init__(self, key: str, value: object, expected: str) -> None:
        super().__init__(key, value, expected)
        self.key, self.value, self.expected = key, value, expected

    def __str__(self) -> str:
        return f"{self.key} = {self.value!r:.300}: {self.expected}"

    def under(self, section: str) -> InvalidValue:
        """The same error with its key inside `section`: ``a`` becomes ``section.a``."""
        return type(self)(f"{section}.{self.key}", self.value, self.expected)


class InvalidType(InvalidValue, TypeError):
    """A value of the wrong type."""


class KeyProblem(InvalidValue):
    """A key that is unknown, missing or given twice; its value is not at fault."""

    def __str__(self) -> str:
        return f"{self.key}: {self.expected}"


def expect(holds: object, key: str, value: object, expected: str) -> None:
    """Refuse, with an InvalidValue, a value that is not what is `expected`."""
    if not holds:
        raise InvalidValue(key, value, f"expected {expected}")


def known_names(name: object, known: Iterable[str]) -> str:
    """``; did you mean 'x'? (known: 'x', 'y')``, the question only if a known name is close."""
    names = list(known)
    return f"{did_you_mean(name, names)} (known: {', '.join(map(repr, names))})"


Function = TypeVar("Function", bound=Callable[..., Any])


@dataclass(frozen=True)
class Kinds:
    """Classes of a section by the name that the entry `key` of its table has.

    Where it has none, a key that is `telling` says the name, or else it is `default`.
    """

    key: str
    classes: Mapping[str, type[Any]]
    default: str = ""
    telling: Mapping[str, str] = dataclasses.field(default_factory=dict)

    def named(self, table: Mapping[str, Any]) -> Any:
        """The name that a table says, not checked; None if it says none."""
        told = (name for key, name in self.telling.items() if key in table)
        return table[self.key] if self.key in table else next(told, None)


@dataclass(frozen=True)
class Quantity:
    """What a field holds: its meaning, unit, and allowed range (numbers) or choices (strings).

    `kinds` are the classes of a section, or sections, of which a table has to name one; `formerly`
    is the key that the field had in older files. Outside of `usual` a value is told, not refused.
    """

    doc: str = ""
    unit: str = ""
    low: float = -math.inf
    high: float = math.inf
    open_low: bool = False
    open_high: bool = False
    choices: tuple[str, ...] = ()
    kinds: Kinds | None = None
    formerly: str = ""
    usual: tuple[float, float] | None = None

    def bounds(self) -> dict[str, Any]:
        """The finite ends of the range, as pydantic's `Field` takes them."""
        low = {"gt" if self.open_low else "ge": self.low}
        high = {"lt" if self.open_high else "le": self.high}
        return {name: end for name, end in (low | high).items() if math.isfinite(end)}

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

    def expectation(self, annotation: Any, table: bool = False) -> str:
        """What the field takes, in words: ``expected a number in [0, 1) (orbit eccentricity)``.

        Of a `table` these are the words of a file, of code those of Python.
        """
        meaning = f" ({self.doc})" if self.doc else ""
        return f"expected {self._takes(annotation, table)}{meaning}"

    def _takes(self, annotation: Any, table: bool) -> str:
        classes = (annotation,)
        if get_origin(annotation) in (Union, UnionType):
            classes = tuple(kind for kind in get_args(annotation) if kind is not NoneType)
            if len(classes) < len(get_args(annotation)):
                return f"nothing or {self._takes(Union[classes], table)}"  # noqa: UP007
            if any(get_origin(kind) is tuple for kind in classes):
                return " or ".join(self._takes(kind, table) for kind in classes)
        if get_origin(annotation) is tuple:
            entries = get_args(annotation)
            count = "" if entries[-1] is Ellipsis else f"{len(entries)} x "
            return f"a list of {count}({self._takes(entries[0], table)})"
        if self.choices:
            return "one of " + ", ".join(map(repr, self.choices))
        number = "a number" if self.range_text() else "a finite number"
        known = {float: number, int: "an integer", bool: "true or false", str: "a string"}
        if annotation in known:
            return f"{known[annotation]} {self.range_text()}".strip()
        if table and annotation is datetime:
            return "a date and time with UTC offset, such as 2018-06-05T00:00:00Z"
        names = (getattr(get_origin(cls) or cls, "__name__", str(cls)) for cls in classes)
        return "a table" if table else " or ".join(names)


def quantity(
    default: Any = MISSING, *, factory: Any = MISSING, kw_only: Any = MISSING, **declaration: Any
) -> Any:
    """A dataclass field carrying a `Quantity`, whose attributes are the other keywords."""
    metadata = {"quantity": Quantity(**declaration)}
    return dataclasses.field(
        default=default, default_factory=factory, kw_only=kw_only, metadata=metadata
    )


def positive(default: Any = MISSING, **declaration: Any) -> Any:
    """A `quantity` above 0."""
    return quantity(default, low=0.0, open_low=True, **declaration)


def remembered(function: Function) -> Function:
    """`functools.cache` that keeps the signature; of a class mypy doubts that it is hashable."""
    return cast(Function, cache(function))


@remembered
def declared(cls: type) -> dict[str, tuple[Any, Quantity]]:
    """Annotation and `Quantity` of each field of a dataclass."""
    hints = get_type_hints(cls)
    return {
        field.name: (hints[field.name], field.metadata.get("quantity", Quantity()))
        for field in dataclasses.fields(cls)
    }
