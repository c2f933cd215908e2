"""Errors for invalid settings, which name the key, its value and the expected values."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from mgeo.validation.arguments import format_suggestion


class InvalidValue(ValueError):
    """Error for a setting with an invalid value.

    Attributes
    ----------
    key : str
        Full key of the setting, such as ``orbit.eccentricity``.
    value : object
        Invalid value.
    expected : str
        Text on what was expected.
    """

    def __init__(self, key: str, value: object, expected: str) -> None:
        super().__init__(key, value, expected)
        self.key, self.value, self.expected = key, value, expected

    def __str__(self) -> str:
        return f"{self.key} = {self.value!r:.300}: {self.expected}"

    def prefix_key(self, section: str) -> InvalidValue:
        """Return a copy of the error with a table name prefixed to its key.

        The key ``a`` becomes ``section.a``.
        """
        return type(self)(f"{section}.{self.key}", self.value, self.expected)


class InvalidKey(InvalidValue):
    """Error for an unknown, missing or repeated key."""

    def __str__(self) -> str:
        return f"{self.key}: {self.expected}"


def expect(condition: object, key: str, value: object, expected: str) -> None:
    """Raise InvalidValue if a condition on the value of a key is false.

    The message is ``KEY = VALUE: expected EXPECTED``.
    """
    if not condition:
        raise InvalidValue(key, value, f"expected {expected}")


def expect_unique(key: str, values: Sequence[object]) -> None:
    """Raise InvalidValue if a value occurs more than once in a sequence.

    Parameters
    ----------
    key : str
        Key in the message; ``{}`` stands for the index of the value.
    values : sequence
        Values that must differ from each other.
    """
    for i, value in enumerate(values):
        expect(value not in values[:i], key.format(i), value, "no duplicates")


def format_known_names(name: object, known: Iterable[str]) -> str:
    """Format the end of an error message about an unknown name.

    The text suggests a similar name, if there is one, and lists the known names. The text is, for
    example, ``; did you mean 'x'? (known: 'x', 'y')``.
    """
    names = list(known)
    return f"{format_suggestion(name, names)} (known: {', '.join(map(repr, names))})"
