"""Sections as nested tables: dicts and lists of plain values, as JSON has them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import is_dataclass
from datetime import datetime
from typing import Any

from .errors import InvalidValue
from .quantity import Kinds, declared


def to_table(section: Any) -> dict[str, Any]:
    """Inverse of `from_table`; times become ISO 8601 strings."""
    values = {key: getattr(section, key) for key in declared(type(section))}
    # TOML has no word for nothing: what is not given is left out
    given = {key: value for key, value in values.items() if value is not None and value != ()}
    kinds = {key: spec.kinds for key, (_, spec) in declared(type(section)).items()}
    return {key: _plain(value, kinds[key]) for key, value in given.items()}


def require_same(name: str, one: Any, other: Any, keys: Iterable[str]) -> None:
    """Refuse a section that differs from another in some keys.

    Parameters
    ----------
    name : str
        What the first one is called in the message; the other is the scenario.
    keys : iterable of str
        Such as ``step`` or ``orbit``.

    Raises
    ------
    InvalidValue
        (ValueError) Naming the first key that differs, ``orbit.eccentricity``, and both values.
    """
    own, others = to_table(one), to_table(other)
    for key in keys:
        found = _difference(own.get(key), others.get(key), f"{name}.{key}")
        if found:
            place, value, expected = found
            raise InvalidValue(place, value, f"expected the scenario's {expected!r}")


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


def _difference(one: Any, other: Any, place: str) -> tuple[str, Any, Any] | None:
    """Key and both values of the first entry that differs; None stands for one not given."""
    if isinstance(one, Mapping) and isinstance(other, Mapping):
        for key in dict.fromkeys([*one, *other]):
            found = _difference(one.get(key), other.get(key), f"{place}.{key}")
            if found:
                return found
        return None
    return None if one == other else (place, one, other)
