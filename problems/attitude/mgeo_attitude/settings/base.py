"""Base class of settings with validation by pydantic, and conversion to tables.

Errors name key, value and unit. A table is a dict of JSON types.
"""

from __future__ import annotations

import ast
import inspect
import textwrap
from abc import ABCMeta
from collections import ChainMap
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, fields
from datetime import date, datetime
from functools import cache
from typing import Any, ClassVar, TypeVar, get_args

import numpy as np
from pydantic import (
    ConfigDict,
    GetCoreSchemaHandler,
    GetJsonSchemaHandler,
    TypeAdapter,
    ValidationError,
    model_validator,
)
from pydantic.fields import FieldInfo
from pydantic_core import ArgsKwargs, CoreSchema, core_schema

from mgeo.validation.field_docstrings import parse_field_docstrings
from mgeo_attitude.settings.errors import InvalidKey, InvalidValue, format_known_names
from mgeo_attitude.settings.schema_description import describe_schema
from mgeo_attitude.settings.types import Schema

T = TypeVar("T")


class _ErrorConversion(ABCMeta):
    """Metaclass that converts pydantic's validation errors to `InvalidValue`."""

    def __call__(cls, *args: Any, **kwargs: Any) -> Any:
        try:
            return super().__call__(*args, **kwargs)
        except ValidationError as error:
            raise _convert_error(error, cls) from None


class Settings(metaclass=_ErrorConversion):
    """Base class of frozen pydantic dataclasses, each of which represents a table of a TOML file.

    Validation is strict: a bool is not a number, numbers must be finite, and text is not converted
    to numbers. An int is converted to a float, a numpy number to a Python number, a list or
    numpy array to a tuple, and a mapping to the settings of its field. Subclasses define
    further checks in ``__post_init__``.

    Raises
    ------
    InvalidValue
        (ValueError) If a value is invalid; the message names the key, its value and the expected
        values.
    """

    __pydantic_config__ = ConfigDict(
        strict=True,
        allow_inf_nan=False,
        extra="forbid",
        arbitrary_types_allowed=True,
    )
    #: Key of a table that selects one of several classes, such as ``kind``, if it is not a field.
    selector: ClassVar[str] = ""

    @model_validator(mode="wrap")
    @classmethod
    def _convert(cls, value: Any, validate: Callable[[Any], Any]) -> Any:
        if isinstance(value, Mapping):
            return cls(**value)
        if isinstance(value, ArgsKwargs):
            kwargs = {key: _convert_numpy(each) for key, each in (value.kwargs or {}).items()}
            value = ArgsKwargs(_convert_numpy(value.args), kwargs)
        return validate(value)

    @classmethod
    def __get_pydantic_json_schema__(
        cls, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> Schema:
        reference = handler(schema)
        definition = handler.resolve_ref_schema(reference)
        definition["description"] = " ".join((cls.__doc__ or "").partition("\n\n")[0].split())
        texts = ChainMap(*map(_field_docstrings, cls.__mro__[: cls.__mro__.index(Settings)]))
        for key, entry in definition["properties"].items():
            text = get_fields(cls)[key].description or texts.get(key, "")
            entry["description"] = " ".join(text.split())
        if name := getattr(cls, cls.selector, ""):
            kind = {"const": name, "description": "class of the table"}
            definition["properties"] = {cls.selector: kind} | definition["properties"]
        return reference


def _field_docstrings(cls: type) -> dict[str, str]:
    """Return the docstring of each field that a class defines, as a dict keyed by field name.

    Inherited fields are not included. The docstrings are read from the source on demand, for a
    schema or a message, since reading all of them at import takes a sixth of a second.
    """
    (definition,) = ast.parse(textwrap.dedent(inspect.getsource(cls))).body
    assert isinstance(definition, ast.ClassDef)
    return parse_field_docstrings(definition)


def get_fields(cls: type) -> dict[str, FieldInfo]:
    """Return the pydantic `FieldInfo` of each field of a settings class, keyed by field name."""
    result: dict[str, FieldInfo] = cls.__pydantic_fields__  # type: ignore[attr-defined]
    return result


def get_annotation(cls: type, key: str, kind: type[T]) -> T | None:
    """Find the first annotation of a given class, such as `Unit`, on a settings field.

    Return None if there is no such annotation.

    Parameters
    ----------
    cls : type
        Settings class.
    key : str
        Name of the field.
    kind : type
        Class of the annotation.
    """
    matches = (each for each in get_fields(cls)[key].metadata if isinstance(each, kind))
    return next(matches, None)


@cache
def build_schema(cls: type) -> Schema:
    """Return the JSON Schema of a settings class, as a dict."""
    return TypeAdapter(cls).json_schema()


def _convert_numpy(value: Any) -> Any:
    """Convert numpy scalars to Python numbers, and lists and arrays to tuples, recursively."""
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if isinstance(value, list | tuple):
        return tuple(map(_convert_numpy, value))
    return value.item() if isinstance(value, np.generic) else value


def _convert_error(error: ValidationError, cls: Any) -> ValueError:
    """Convert a pydantic validation error to an `InvalidValue` or `InvalidKey`.

    An error about an unknown key takes precedence over other errors.
    """
    errors = error.errors(include_url=False)
    unknown = (each for each in errors if each["type"].startswith("unexpected_"))
    first = next(unknown, errors[0])
    cause = first.get("ctx", {}).get("error")
    if not first["loc"]:  # The error is from __post_init__.
        return cause if isinstance(cause, ValueError) else error
    key, *path = first["loc"]
    if isinstance(key, int):
        key = [each.name for each in fields(cls) if not each.kw_only][key]
    if first["type"].startswith("unexpected_"):
        names = [cls.selector] if cls.selector else []
        known = format_known_names(key, [*names, *get_fields(cls)])
        return InvalidKey(key, first["input"], f"unknown key{known}")
    schema = build_schema(cls)["properties"][key]
    if path and isinstance(path[0], str) and "anyOf" in schema:
        path = []  # For a union, the path names the alternatives.
    is_missing = first["type"] == "missing"
    expected = f"expected {describe_schema(schema)}"
    if path and not is_missing:  # The error is in an entry of a list or table.
        unit = f" [{schema['unit']}]" if "unit" in schema else ""
        expected = first["msg"].replace("Input should be", "expected") + unit
    expected += f" ({schema['description']})"
    if is_missing and not path:
        return InvalidKey(key, None, f"missing; {expected}")
    entry = path[:-1] if is_missing else path  # If an entry is missing, a list is too short.
    key += "".join(f"[{each}]" if isinstance(each, int) else f".{each}" for each in entry)
    if isinstance(cause, InvalidValue):
        return cause.prefix_key(key)
    value = first["input"]
    value = value.isoformat() if isinstance(value, date) else value
    return InvalidValue(key, value, str(cause) if cause else expected)


Table = dict[str, Any]


@dataclass(frozen=True)
class TableClasses:
    """Annotation that converts the table of a field to one of several settings classes.

    The entry `key` of a table selects the class by name. Without this entry, the first key of
    `identifying_keys` that the table contains selects the class, or else the class is `default`.

    Attributes
    ----------
    key : str
        Entry that names the class, such as ``kind``.
    classes : mapping of str to type
        Settings classes by name.
    default : str
        Name of the class of a table that selects none; empty if a class must be selected.
    identifying_keys : mapping of str to str
        Names of classes by a key that only this class has.
    """

    key: str
    classes: Mapping[str, type[Any]]
    default: str = ""
    identifying_keys: Mapping[str, str] = field(default_factory=dict)

    def get_class_name(self, table: Mapping[str, Any]) -> Any:
        """Return the name of the class that a table selects, or None if it selects no class.

        The class need not exist.
        """
        names = (name for key, name in self.identifying_keys.items() if key in table)
        return table[self.key] if self.key in table else next(names, None)

    def convert(self, value: Any) -> Any:
        """Convert a table to an instance of the settings class that it selects.

        A value that is not a table is returned unchanged.

        Raises
        ------
        InvalidValue
            If the table selects no class or an unknown class.
        """
        if not isinstance(value, Mapping):
            return value
        name = self.get_class_name(value)
        name = self.default if name is None else name
        cls = self.classes.get(name) if isinstance(name, str) else None
        if cls is None:
            expected = f"unknown {self.key}{format_known_names(name, self.classes)}"
            raise InvalidValue(self.key, name, expected)
        return cls(**{k: v for k, v in value.items() if k != self.key or k in get_fields(cls)})

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        classes = tuple(dict.fromkeys(self.classes.values()))
        tables = core_schema.union_schema([handler.generate_schema(cls) for cls in classes])
        bases = get_args(source) or (source,)
        description = f"{' or '.join(base.__name__ for base in bases)}, or a table"
        instance = core_schema.is_instance_schema((*bases, *classes), cls_repr=description)
        python_schema = core_schema.no_info_before_validator_function(self.convert, instance)
        return core_schema.json_or_python_schema(json_schema=tables, python_schema=python_schema)


def to_table(settings: Any) -> Table:
    """Convert settings to a dict of JSON types, as in a table of a TOML or JSON file.

    Times become ISO 8601 text. Fields that are None or an empty tuple are left out, since TOML has
    no null value.
    """
    values = {key: getattr(settings, key) for key in get_fields(type(settings))}
    selector = type(settings).selector
    name = {selector: getattr(settings, selector)} if selector else {}
    return name | {k: _convert_entry(v) for k, v in values.items() if v is not None and v != ()}


def flatten_keys(values: Any) -> Any:
    """Flatten nested mappings to one dict with dotted keys: ``{"mag": {"bias": 1}}`` becomes
    ``{"mag.bias": 1}``.

    A value that is not a mapping is returned unchanged.

    Raises
    ------
    InvalidKey
        If two entries have the same dotted key.
    """
    if not isinstance(values, Mapping):
        return values
    flat: Table = {}
    for name, value in values.items():
        nested = flatten_keys(value) if isinstance(value, Mapping) else {"": value}
        for suffix, number in nested.items():
            key = f"{name}.{suffix}" if suffix else str(name)
            if key in flat:
                raise InvalidKey(key, number, "given twice, nested and with a dot")
            flat[key] = number
    return flat


def require_same(name: str, settings: Any, expected_settings: Any, keys: Iterable[str]) -> None:
    """Raise InvalidValue if one of the given fields differs from the expected settings.

    Parameters
    ----------
    name : str
        Name of the settings in the message.
    settings, expected_settings : Settings
        Settings to check, and settings of the scenario.
    keys : iterable of str
        Fields to compare. The message names the first difference, such as ``orbit.eccentricity``,
        and both values.
    """
    tables = to_table(settings), to_table(expected_settings)
    for key in keys:
        values, expected = (flatten_keys({key: table.get(key)}) for table in tables)
        for path in dict.fromkeys([*values, *expected]):
            if values.get(path) != expected.get(path):
                text = f"expected the scenario's {expected.get(path)!r:.300}"
                raise InvalidValue(f"{name}.{path}", values.get(path), text)


def _convert_entry(value: Any) -> Any:
    if isinstance(value, Mapping):
        return dict(value)
    if isinstance(value, tuple):
        return [_convert_entry(entry) for entry in value]
    if isinstance(value, datetime):
        return value.isoformat().replace("+00:00", "Z")
    return to_table(value) if isinstance(value, Settings) else value
