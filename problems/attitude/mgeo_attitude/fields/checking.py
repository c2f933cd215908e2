"""Sections as pydantic checks them, whether code makes them or a file's tables."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import MISSING, dataclass
from datetime import datetime
from functools import partial
from numbers import Integral, Real
from types import UnionType
from typing import Annotated, Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, create_model
from pydantic import GetCoreSchemaHandler as Handler
from pydantic import ValidationInfo as Info
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from .errors import InvalidValue, KeyProblem, known_names
from .numbers import flattened
from .quantity import Kinds, Quantity, declared, remembered
from .words import in_words

_CONFIG = ConfigDict(
    strict=True,
    extra="forbid",
    arbitrary_types_allowed=True,
    field_title_generator=lambda name, info: name,
)
_TABLE = "table"  # context of a validation in which sections and times are those of a file

Section = TypeVar("Section")


def from_table(
    cls: type[Section], table: Mapping[str, Any], key: str = "", names: tuple[str, ...] = ()
) -> Section:
    """A section from a table of its fields and, perhaps, the further `key`, one of `names`.

    Sections in it are tables, too, and times may be texts.

    Raises
    ------
    KeyProblem, InvalidValue, InvalidType
        Naming the full key (``orbit.eccentricity``): unknown, missing or of a bad value.
    """
    fields, model = declared(cls), section_model(cls, key, names)
    with in_words(table, fields, model.model_fields, table=True):
        read = model.model_validate(dict(table), context=_TABLE)
    return cls(**{name: getattr(read, name) for name in fields if name in read.model_fields_set})


def checked_fields(section: Any) -> dict[str, Any]:
    """The fields of a section as their annotations want them: an int as float, a list as tuple."""
    fields, model = declared(type(section)), section_model(type(section))
    given = {name: getattr(section, name) for name in fields}
    with in_words(given, fields):
        read = model.model_validate(given)
    return {name: getattr(read, name) for name in fields}


@remembered
def section_model(cls: Any, key: str = "", names: tuple[str, ...] = ()) -> type[BaseModel]:
    """The pydantic model of a section's fields, with `key`, one of `names`, before them."""
    hints = get_type_hints(cls, include_extras=True)
    entries: dict[str, Any] = {key: (Literal[names], Field(**_default(None)))} if key else {}
    fields = {field.name: field for field in dataclasses.fields(cls)}
    for name, (_, spec) in declared(cls).items():
        field = fields[name]
        required = field.default is MISSING and field.default_factory is MISSING
        text = f"{spec.doc} [{spec.unit}]" if spec.unit else spec.doc
        default = {} if required else _default(field.default)
        info = Field(description=text or None, **default)
        entries[name] = (_checked_type(hints[name], spec), info)
    return create_model(cls.__name__, __config__=_CONFIG, **entries)


def _checked_type(hint: Any, spec: Quantity) -> Any:
    """A field's annotation as pydantic shall check it."""
    entries = get_args(hint)
    if get_origin(hint) is tuple:
        own = tuple(kind if kind is Ellipsis else _checked_type(kind, spec) for kind in entries)
        return Annotated[tuple[own], BeforeValidator(_as_tuple)]  # type: ignore[valid-type]
    if spec.kinds:
        return Annotated[hint, _Sections(entries or (hint,), spec.kinds)]
    if get_origin(hint) in (Union, UnionType):
        return Union[tuple(_checked_type(kind, spec) for kind in entries)]  # noqa: UP007
    if hint is float:
        bounds = Field(allow_inf_nan=False, **spec.bounds())
        return Annotated[float, bounds, BeforeValidator(partial(_as_number, float, Real))]
    if hint is int:
        bounds = Field(**spec.bounds())
        return Annotated[int, bounds, BeforeValidator(partial(_as_number, int, Integral))]
    if get_origin(hint) is Annotated:  # Mapping[str, float], made a subclass of Numbers
        number: Any = _checked_type(float, spec)
        nested = dict[str, number | dict[str, number]]
        flat = BeforeValidator(flattened, json_schema_input_type=nested)
        return Annotated[dict[str, number], flat, AfterValidator(entries[1])]
    if hint is datetime:
        return Annotated[datetime, BeforeValidator(_as_datetime)]
    if hasattr(hint, "__dataclass_fields__"):
        return Annotated[hint, _Sections((hint,))]
    return Literal[spec.choices] if spec.choices else hint  # such as a class of somebody else's


@dataclass(frozen=True)
class _Sections:
    """Reads a section of some classes: as it is or, from a table, of the kind that it names."""

    classes: tuple[type[Any], ...]
    kinds: Kinds | None = None

    def __get_pydantic_core_schema__(self, source: Any, handler: Handler) -> CoreSchema:
        kinds = self.kinds
        models = [section_model(cls) for cls in self.classes]
        if kinds:
            each = dict.fromkeys(kinds.classes.values())
            models = [section_model(cls, kinds.key, kinds.names(cls)) for cls in each]
        shapes: list[Any] = [handler.generate_schema(model) for model in models]
        return core_schema.with_info_plain_validator_function(
            self._read, json_schema_input_schema=core_schema.union_schema(shapes)
        )

    def _read(self, value: Any, info: Info) -> Any:
        if isinstance(value, self.classes):
            return value
        if not (info.context == _TABLE and isinstance(value, Mapping)):
            raise PydanticCustomError("section_type", "no section")
        if self.kinds is None:
            return from_table(self.classes[0], value)
        key, classes = self.kinds.key, self.kinds.classes
        if not (key in value or self.kinds.default):
            raise KeyProblem(key, None, f"missing{known_names('', classes)}")
        name = value.get(key, self.kinds.default)
        if not isinstance(name, str) or name not in classes:
            raise InvalidValue(key, name, f"unknown {key}{known_names(name, classes)}")
        return from_table(classes[name], value, key, self.kinds.names(classes[name]))


def _default(value: Any) -> dict[str, Any]:
    """A default as pydantic's `Field` takes it; a schema shows it if it is a plain value."""
    plain = isinstance(value, bool | int | float | str | tuple)
    return {"default": value} if plain else {"default_factory": lambda: None}


def _as_tuple(value: Any) -> Any:
    return tuple(value) if isinstance(value, list) else value


def _as_number(kind: type[float], abstract: type[Any], value: Any) -> float:
    """A number of Python; the abstract classes cover those of numpy."""
    if isinstance(value, bool) or not isinstance(value, abstract):
        raise PydanticCustomError("number_type", "no number")
    try:
        return kind(value)
    except OverflowError:  # an integer that no float can hold
        return math.inf


def _as_datetime(value: Any, info: Info) -> Any:
    if not (info.context == _TABLE and isinstance(value, str)):
        return value
    try:
        return datetime.fromisoformat(value)
    except ValueError:
        raise PydanticCustomError("no_datetime", "no date and time") from None
