"""Field types of settings: units, numbers with ranges, vectors, instants and choices."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Annotated, Any, TypeVar, Union

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Field,
    GetJsonSchemaHandler,
    GetPydanticSchema,
)
from pydantic_core import CoreSchema, core_schema

Schema = dict[str, Any]


@dataclass(frozen=True)
class Unit:
    """Unit of a quantity, with its suffix in keys and its conversion factor.

    A unit annotates the field of a setting, or describes a block of the filter's error state.

    Attributes
    ----------
    text : str
        Unit for display, such as deg/h.
    suffix : str
        Unit as a suffix of keys, such as deg_h; empty for none.
    factor : float
        Factor from the filter's unit to this unit.
    """

    text: str
    suffix: str = ""
    factor: float = 1.0

    def build_key(self, name: str) -> str:
        """Return the key of a quantity in a scenario file: its name, followed by a unit suffix."""
        return f"{name}_{self.suffix}" if self.suffix else name

    @property
    def key_factor(self) -> float:
        """Factor from the filter's unit to the unit of the key in a scenario file.

        The factor is 1 if the key has no suffix.
        """
        return self.factor if self.suffix else 1.0

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> Schema:
        return handler(schema) | {"unit": self.text}


DIMENSIONLESS = Unit("-")
#: Error of a component of a unit vector, as the small angle by which the error rotates the vector.
ARCMIN = Unit("arcmin", "", 60.0 * math.degrees(1.0))
PPM = Unit("ppm", "", 1e6)
SECOND = Unit("s", "s", 1.0)
DEG = Unit("deg", "deg", math.degrees(1.0))
DEG_H = Unit("deg/h", "deg_h", 3600.0 * math.degrees(1.0))


@dataclass(frozen=True)
class UsualRange:
    """Usual range of a setting, outside of which a nonzero value causes a warning."""

    low: float
    high: float


def restrict_to(names: Iterable[str]) -> GetPydanticSchema:
    """Return an annotation for a field that accepts only the given strings."""
    choices = list(names)
    return GetPydanticSchema(lambda source, handler: core_schema.literal_schema(choices))


def _parse_instant(value: Any) -> Any:
    try:
        return datetime.fromisoformat(value) if isinstance(value, str) else value
    except ValueError:
        return value


def _to_utc(instant: datetime) -> datetime:
    if instant.utcoffset() is None:
        raise ValueError("expected a UTC offset, such as a Z at the end")
    try:
        return instant.astimezone(UTC)
    except OverflowError:
        raise ValueError("expected a time in the years 1 to 9999 of UTC") from None


def _check_direction(vector: tuple[float, float, float]) -> tuple[float, float, float]:
    if not any(vector):
        raise ValueError("expected a direction, not zero")
    return vector


def _check_display_name(text: str) -> str:
    if not (text.isprintable() and text.strip()):
        raise ValueError("expected printable characters on one line")
    return text


T = TypeVar("T")

#: Name that is part of keys and column names.
Identifier = Annotated[str, Field(pattern=r"^[A-Z_a-z0-9-]+$")]
#: Name for display, on one line.
DisplayName = Annotated[str, AfterValidator(_check_display_name)]
Seconds = Annotated[float, Unit("s")]
Degrees = Annotated[float, Unit("deg")]
DegreesPerSecond = Annotated[float, Unit("deg/s")]
Positive = Annotated[float, Field(gt=0.0)]
NonNegative = Annotated[float, Field(ge=0.0)]
Triple = tuple[T, T, T]
Vector = Triple[float]
#: Nonzero vector.
Direction = Annotated[Vector, AfterValidator(_check_direction)]
#: One number for all three axes, or three numbers, one per axis.
PerAxis = Union[T, tuple[T, T, T]]  # noqa: UP007
#: Instant with UTC offset, or its ISO 8601 text in a file; converted to UTC.
Instant = Annotated[datetime, BeforeValidator(_parse_instant), AfterValidator(_to_utc)]
