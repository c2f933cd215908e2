"""Sections as nested tables: dicts and lists of plain values, as JSON has them."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping
from dataclasses import MISSING, is_dataclass
from datetime import datetime
from typing import Any, TypeVar, get_args, get_origin

from mgeo_attitude.fields.quantity import (
    InvalidType,
    InvalidValue,
    KeyProblem,
    Kinds,
    Quantity,
    declared,
    known_names,
)

Section = TypeVar("Section")


def from_table(cls: type[Section], table: Mapping[str, Any], key: str = "") -> Section:
    """A section from a table of its fields and, perhaps, the further `key`, which has been read.

    Sections in it are tables, too, and times may be texts. A key that is unknown, missing or of a
    bad value is an InvalidValue, InvalidType or KeyProblem with the full key, ``orbit.raan_deg``.
    """
    fields = declared(cls)
    for name, value in table.items():
        if name not in fields and name != key:
            renamed = [new for new, (_, spec) in fields.items() if spec.formerly == name]
            known = known_names(name, dict.fromkeys([key, *fields] if key else fields))
            expected = f"is now called {renamed[0]!r}" if renamed else f"unknown key{known}"
            raise KeyProblem(str(name), value, expected)
    for field in dataclasses.fields(cls):  # type: ignore[arg-type]
        if field.name not in table and field.default is field.default_factory is MISSING:
            annotation, spec = fields[field.name]
            expected = f"missing; {spec.expectation(annotation, table=True)}"
            raise KeyProblem(field.name, None, expected)
    return cls(**{k: _read(k, table[k], *fields[k]) for k in fields if k in table})


def to_table(section: Any) -> dict[str, Any]:
    """Inverse of `from_table`; times become ISO 8601 strings."""
    values = {k: (getattr(section, k), spec) for k, (_, spec) in declared(type(section)).items()}
    # TOML has no word for nothing: what is not given is left out
    given = {k: pair for k, pair in values.items() if pair[0] is not None and pair[0] != ()}
    return {k: _plain(value, spec.kinds) for k, (value, spec) in given.items()}


def flattened(values: Any) -> Any:
    """``{"mag.bias": 1}`` from ``{"mag": {"bias": 1}}``, and what is no mapping as it is."""
    if not isinstance(values, Mapping):
        return values
    flat: dict[str, Any] = {}
    for name, value in values.items():
        nested = flattened(value) if isinstance(value, Mapping) else {"": value}
        for rest, number in nested.items():
            key = f"{name}.{rest}" if rest else str(name)
            if key in flat:
                raise KeyProblem(key, number, "given twice")
            flat[key] = number
    return flat


def require_same(name: str, one: Any, other: Any, keys: Iterable[str]) -> None:
    """Refuse, with an InvalidValue, a section called `name` that differs from the scenario's.

    The message names the first of the `keys` that differs, ``orbit.eccentricity``, and both values.
    """
    own, others = to_table(one), to_table(other)
    for key in keys:
        found, expected = ({key: table.get(key)} for table in (own, others))
        if isinstance(found[key], Mapping) and isinstance(expected[key], Mapping):
            found, expected = flattened(found), flattened(expected)
        for place in dict.fromkeys([*found, *expected]):
            if found.get(place) != expected.get(place):
                wanted = f"expected the scenario's {expected.get(place)!r:.300}"
                raise InvalidValue(f"{name}.{place}", found.get(place), wanted)


def _read(key: str, value: Any, annotation: Any, spec: Quantity) -> Any:
    """A value of a table, in which tables have become sections, and texts times."""
    if value is None or is_dataclass(value):
        return value
    origin, entries = get_origin(annotation), get_args(annotation) or (annotation,)
    if origin is tuple and isinstance(value, list | tuple):
        return tuple(_read(f"{key}[{i}]", v, entries[0], spec) for i, v in enumerate(value))
    expected = spec.expectation(annotation, table=True)
    if annotation is datetime and isinstance(value, str):
        try:
            return datetime.fromisoformat(value)
        except ValueError:
            raise InvalidValue(key, value, expected) from None
    sections = [cls for cls in entries if isinstance(cls, type) and is_dataclass(cls)]
    wanted = Mapping if sections and origin is not tuple else origin or annotation
    if wanted in (Mapping, datetime, tuple) and not isinstance(value, wanted):
        raise InvalidType(key, value, expected)
    try:
        return _section(sections[0], value, spec.kinds) if sections else value
    except InvalidValue as error:
        raise error.under(key) from None


def _section(cls: type[Any], table: Mapping[str, Any], kinds: Kinds | None) -> Any:
    """A section from a table that names its kind, if there are several."""
    if kinds is None:
        return from_table(cls, table)
    name = kinds.named(table) or table.get(kinds.key, kinds.default)
    if not name and kinds.key not in table:
        raise KeyProblem(kinds.key, None, f"missing{known_names('', kinds.classes)}")
    if not isinstance(name, str) or name not in kinds.classes:
        expected = f"unknown {kinds.key}{known_names(name, kinds.classes)}"
        raise InvalidValue(kinds.key, name, expected)
    cls = kinds.classes[name]
    for key, other in kinds.telling.items():
        if key in table and key not in declared(cls):
            raise KeyProblem(key, table[key], f"no key of {kinds.key} = {name!r}, but of {other!r}")
    return from_table(cls, table, kinds.key)


def _plain(value: Any, kinds: Kinds | None) -> Any:
    if isinstance(value, Mapping):
        return dict(value)
    if isinstance(value, tuple):
        return [_plain(entry, kinds) for entry in value]
    if isinstance(value, datetime):
        return value.isoformat().replace("+00:00", "Z")
    if is_dataclass(value):
        return ({kinds.key: getattr(value, kinds.key)} if kinds else {}) | to_table(value)
    return value
