"""Numbers by name: a section whose keys are not known beforehand."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from .errors import KeyProblem
from .quantity import Quantity


class Numbers(Mapping[str, float]):
    """Numbers by names with dots, which a table may nest; immutable and hashable.

    Raises
    ------
    InvalidValue, InvalidType
        For a number out of range, or something that is no number.
    KeyProblem
        For a name given twice.
    """

    __slots__ = ("_values",)
    _spec = Quantity()

    def __init__(self, values: Mapping[str, Any] | None = None) -> None:
        from .checking import checked

        flat = _flat(values or {})
        self._values: dict[str, float] = {
            name: checked(name, flat[name], float, self._spec) for name in flat
        }

    def __getitem__(self, name: str) -> float:
        return self._values[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def __hash__(self) -> int:
        return hash(frozenset(self._values.items()))

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self._values})"


def _flat(values: Mapping[str, Any]) -> dict[str, Any]:
    """``{"mag.bias": 1}`` from ``{"mag": {"bias": 1}}``."""
    flat: dict[str, Any] = {}
    for name, value in values.items():
        nested = _flat(value) if isinstance(value, Mapping) else {"": value}
        for rest, number in nested.items():
            key = f"{name}.{rest}" if rest else name
            if key in flat:
                raise KeyProblem(key, number, "given twice")
            flat[key] = number
    return flat
