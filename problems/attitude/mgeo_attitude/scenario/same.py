"""What two scenarios must have in common."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from ..fields import InvalidValue
from .scenario import Scenario
from .tables import to_table


def require_same(name: str, one: Scenario, scenario: Scenario, keys: Iterable[str]) -> None:
    """Refuse a scenario that differs from another in some keys.

    Parameters
    ----------
    name : str
        What the first one is called in the message.
    keys : iterable of str
        Of a scenario, such as ``step`` or ``orbit``.

    Raises
    ------
    InvalidValue
        (ValueError) Naming the first key that differs, ``orbit.eccentricity``, and both values.
    """
    own, others = to_table(one), to_table(scenario)
    for key in keys:
        found = _difference(own.get(key), others.get(key), f"{name}.{key}")
        if found:
            place, value, expected = found
            raise InvalidValue(place, value, f"expected the scenario's {expected!r}")


def _difference(one: Any, other: Any, place: str) -> tuple[str, Any, Any] | None:
    """Key and both values of the first entry that differs; None stands for one not given."""
    if isinstance(one, Mapping) and isinstance(other, Mapping):
        for key in dict.fromkeys([*one, *other]):
            found = _difference(one.get(key), other.get(key), f"{place}.{key}")
            if found:
                return found
        return None
    return None if one == other else (place, one, other)
