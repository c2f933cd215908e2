"""Settings as nested tables: dicts and lists of plain values, as JSON has them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from datetime import datetime
from typing import Any, get_args

from pydantic import GetCoreSchemaHandler
from pydantic_core import CoreSchema, core_schema

from mgeo_attitude.settings.base import Settings, declared
from mgeo_attitude.settings.errors import InvalidValue, KeyProblem, known_names

Table = dict[str, Any]


@dataclass(frozen=True)
class Kinds:
    """Annotation of a field that takes one of several classes of settings.

    A table names its class by the entry `key`. Without this entry, a key among `telling` names the
    class, or else the class is `default`.
    """

    key: str
    classes: Mapping[str, type[Any]]
    default: str = ""
    telling: Mapping[str, str] = field(default_factory=dict)

    def name_of(self, table: Mapping[str, Any]) -> Any:
        """Return the name in a table, unchecked; None if the table has none."""
        names = (name for key, name in self.telling.items() if key in table)
        return table[self.key] if self.key in table else next(names, None)

    def read(self, value: Any) -> Any:
        """Convert a table to the settings that it names; return other values unchanged."""
        if not isinstance(value, Mapping):
            return value
        name = self.name_of(value) or value.get(self.key, self.default)
        if not name and self.key not in value:
            raise KeyProblem(self.key, None, f"missing{known_names('', self.classes)}")
        if not isinstance(name, str) or name not in self.classes:
            expected = f"unknown {self.key}{known_names(name, self.classes)}"
            raise InvalidValue(self.key, name, expected)
        cls = self.classes[name]
        return cls(**{k: v for k, v in value.items() if k != self.key or k in declared(cls)})

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        classes = tuple(dict.fromkeys(self.classes.values()))
        tables = core_schema.union_schema([handler.generate_schema(cls) for cls in classes])
        bases = get_args(source) or (source,)
        words = f"{' or '.join(base.__name__ for base in bases)}, or a table"
        instance = core_schema.is_instance_schema((*bases, *classes), cls_repr=words)
        read = core_schema.no_info_before_validator_function(self.read, instance)
        return core_schema.json_or_python_schema(json_schema=tables, python_schema=read)


def to_table(settings: Any) -> Table:
    """Return settings as a table; times become ISO 8601 text, and what is empty is left out."""
    values = {key: getattr(settings, key) for key in declared(type(settings))}
    selector = type(settings).selector
    name = {selector: getattr(settings, selector)} if selector else {}
    # TOML has no word for nothing
    return name | {k: _plain(v) for k, v in values.items() if v is not None and v != ()}


def flatten(values: Any) -> Any:
    """Return ``{"mag.bias": 1}`` for ``{"mag": {"bias": 1}}``; other values unchanged."""
    if not isinstance(values, Mapping):
        return values
    flat: Table = {}
    for name, value in values.items():
        nested = flatten(value) if isinstance(value, Mapping) else {"": value}
        for rest, number in nested.items():
            key = f"{name}.{rest}" if rest else str(name)
            if key in flat:
                raise KeyProblem(key, number, "given twice")
            flat[key] = number
    return flat


def require_same(name: str, one: Any, other: Any, keys: Iterable[str]) -> None:
    """Raise an `InvalidValue` if settings called `name` differ from the scenario's.

    The message names the first of the `keys` that differs, ``orbit.eccentricity``, and both values.
    """
    found, expected = to_table(one), to_table(other)
    for key in keys:
        own, others = (flatten({key: table.get(key)}) for table in (found, expected))
        for place in dict.fromkeys([*own, *others]):
            if own.get(place) != others.get(place):
                wanted = f"expected the scenario's {others.get(place)!r:.300}"
                raise InvalidValue(f"{name}.{place}", own.get(place), wanted)


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return dict(value)
    if isinstance(value, tuple):
        return [_plain(entry) for entry in value]
    if isinstance(value, datetime):
        return value.isoformat().replace("+00:00", "Z")
    return to_table(value) if isinstance(value, Settings) else value
