"""Numbers by name: a section whose keys are not known beforehand."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from mgeo_attitude.fields.errors import KeyProblem


class Numbers(Mapping[str, float]):
    """Numbers by names with dots, such as ``mag.bias``; immutable and hashable."""

    def __init__(self, values: Mapping[str, float] | None = None) -> None:
        self._values = dict(values or {})

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


def flattened(values: Any) -> Any:
    """``{"mag.bias": 1}`` from ``{"mag": {"bias": 1}}``, and what is no mapping as it is.

    Raises
    ------
    KeyProblem
        For a name given twice.
    """
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
