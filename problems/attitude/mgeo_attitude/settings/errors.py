"""Errors that name a key, its value and what was expected."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from mgeo.validation.arguments import did_you_mean


class InvalidValue(ValueError):
    """A value that is refused: ``key``, ``value``, and what was ``expected`` instead."""

    def __init__(self, key: str, value: object, expected: str) -> None:
        super().__init__(key, value, expected)
        self.key, self.value, self.expected = key, value, expected

    def __str__(self) -> str:
        return f"{self.key} = {self.value!r:.300}: {self.expected}"

    def under(self, section: str) -> InvalidValue:
        """Return the same error with its key inside `section`: ``a`` becomes ``section.a``."""
        return type(self)(f"{section}.{self.key}", self.value, self.expected)


class KeyProblem(InvalidValue):
    """A key that is unknown, missing or given twice; its value is not at fault."""

    def __str__(self) -> str:
        return f"{self.key}: {self.expected}"


def expect(holds: object, key: str, value: object, expected: str) -> None:
    """Raise an `InvalidValue` unless a condition `holds`."""
    if not holds:
        raise InvalidValue(key, value, f"expected {expected}")


def expect_unique(key: str, values: Sequence[object]) -> None:
    """Raise an `InvalidValue` for the first value that is there twice; `key` has ``{}`` for it."""
    for i, value in enumerate(values):
        expect(value not in values[:i], key.format(i), value, "each one once")


def known_names(name: object, known: Iterable[str]) -> str:
    """Return ``; did you mean 'x'? (known: 'x', 'y')``, the question only for a close name."""
    names = list(known)
    return f"{did_you_mean(name, names)} (known: {', '.join(map(repr, names))})"
