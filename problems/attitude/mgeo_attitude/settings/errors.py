"""Errors that name a key, its value and the expected values."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from mgeo.validation.arguments import format_suggestion


class InvalidValue(ValueError):
    """Invalid value with attributes ``key``, ``value`` and ``expected``."""

    def __init__(self, key: str, value: object, expected: str) -> None:
        super().__init__(key, value, expected)
        self.key, self.value, self.expected = key, value, expected

    def __str__(self) -> str:
        return f"{self.key} = {self.value!r:.300}: {self.expected}"

    def prefix_key(self, section: str) -> InvalidValue:
        """Return the error with its key prefixed by a section: ``a`` becomes ``section.a``."""
        return type(self)(f"{section}.{self.key}", self.value, self.expected)


class InvalidKey(InvalidValue):
    """Unknown, missing or repeated key."""

    def __str__(self) -> str:
        return f"{self.key}: {self.expected}"


def expect(condition: object, key: str, value: object, expected: str) -> None:
    """Raise InvalidValue if a condition does not hold."""
    if not condition:
        raise InvalidValue(key, value, f"expected {expected}")


def expect_unique(key: str, values: Sequence[object]) -> None:
    """Raise InvalidValue for the first repeated value; ``{}`` in `key` stands for its index."""
    for i, value in enumerate(values):
        expect(value not in values[:i], key.format(i), value, "each one once")


def format_known_names(name: object, known: Iterable[str]) -> str:
    """Return ``; did you mean 'x'? (known: 'x', 'y')``; the question needs a similar name."""
    names = list(known)
    return f"{format_suggestion(name, names)} (known: {', '.join(map(repr, names))})"
