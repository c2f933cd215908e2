"""JSON documents that read back: plans, calibrations, truths.

Each has its ``format`` and ``version`` first, and the scenario it belongs to. What follows from
other keys is computed again on reading, and a document that says something else is refused.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, TypeVar

from mgeo.store.atomic import to_json
from mgeo.store.reading import parse_json, read_text
from mgeo.validation.tables import entry, errors_of
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.settings.errors import InvalidValue

T = TypeVar("T")

#: A plan of 100 maneuvers is far smaller.
MOST_BYTES = 64 * 2**20

#: Numbers that were computed again, perhaps by other libraries, may differ by this fraction.
TOLERANCE = 1e-6


@dataclass(frozen=True)
class Form(Generic[T]):
    """What documents of one format say of a thing.

    Attributes
    ----------
    name, version : str, int
        Of the format.
    keys : function
        What the thing is made of, the scenario first.
    made : function
        The thing, of a table with these keys and their scenario.
    consequences : function
        What else a document says: on reading, a document is refused that says something else.
    source : str
        What that follows from, in words.
    older : tuple of int
        Versions whose documents are read by their keys alone: what follows was computed otherwise.
    """

    name: str
    version: int
    keys: Callable[[T], Mapping[str, Any]]
    made: Callable[[Mapping[str, Any], Scenario], T]
    consequences: Callable[[T], Mapping[str, Any]]
    source: str
    older: tuple[int, ...] = ()

    def document(self, thing: T) -> dict[str, Any]:
        """All that is said of a thing."""
        first = {"format": self.name, "version": self.version}
        return {**first, **self.keys(thing), **self.consequences(thing)}

    def read(self, text: str) -> T:
        """The thing of a document.

        Raises
        ------
        ValueError, TypeError
            If the text is no JSON, of another format or version, or a key is missing, unknown, of a
            bad value, or does not follow from others; the message names the key.
        """
        table = opened(text, self.name, self.version, self.older)
        thing = self.made(table, scenario_of(table))
        if table["version"] != self.version:
            return thing
        consequences = self.consequences(thing)
        _check_keys(table, ["format", "version", *self.keys(thing), *consequences])
        for key, expected in consequences.items():
            _check_same(key, entry(table, key, type(expected)), expected, self.source)
        return thing


def written(document: Mapping[str, Any]) -> str:
    """A document as text; floats by repr, so that they read back exactly."""
    return to_json(document).decode()


def opened(text: str, kind: str, version: int, older: Sequence[int] = ()) -> dict[str, Any]:
    """The table of a document.

    Raises
    ------
    ValueError
        If the text is no JSON, or of another format or version.
    """
    table = parse_json(text)
    found = table.get("format") if isinstance(table, dict) else None
    if found != kind:
        raise ValueError(f"format = {found!r:.80}: expected {kind!r}")
    said = table.get("version")
    versions = [*older, version]
    if said not in versions or isinstance(said, bool):
        known = " or ".join(map(str, versions))
        raise ValueError(f"version = {said!r:.80}: this package reads version {known}")
    return table  # type: ignore[no-any-return]


def scenario_of(table: Mapping[str, Any]) -> Scenario:
    """The scenario of a document, which has all of it: a preset is not the same for ever.

    Raises
    ------
    ValueError, TypeError
        Naming the key, after ``scenario``.
    """
    own = entry(table, "scenario", dict)
    if "preset" in own:
        whole = "expected all keys in place of a preset, whose values versions of it differ in"
        raise InvalidValue("scenario.preset", own["preset"], whole)
    try:
        return Scenario.from_dict(own)
    except InvalidValue as error:
        raise error.under("scenario") from None


def read_document(path: Path | str, read: Callable[[str], T]) -> T:
    """What a function makes of the text of a file.

    Raises
    ------
    OSError
        If it cannot be read.
    ValueError
        Naming the file, and what the function says of it.
    """
    text = read_text(path, MOST_BYTES)
    with errors_of(path):
        return read(text)


def _check_same(key: str, found: Any, expected: Any, source: str) -> None:
    """Refuse, naming the first key, other data than follow from a source.

    Numbers may be off by `TOLERANCE`.
    """
    if isinstance(expected, dict) and isinstance(found, dict) and found.keys() == expected.keys():
        for name in expected:
            _check_same(f"{key}.{name}", found[name], expected[name], source)
        return
    if isinstance(expected, list) and isinstance(found, list) and len(found) == len(expected):
        for i, (one, other) in enumerate(zip(found, expected, strict=True)):
            _check_same(f"{key}[{i}]", one, other, source)
        return
    if isinstance(expected, float) and type(found) in (int, float):
        # no fraction of a number that is zero but for rounding, as in a quaternion
        close = TOLERANCE * max(abs(expected), TOLERANCE)
        same = expected - close <= found <= expected + close
    else:
        same = type(found) is type(expected) and found == expected
    if not same:
        raise InvalidValue(key, found, f"expected {expected!r}, which follows from {source}")


def _check_keys(table: Mapping[str, Any], known: Sequence[str]) -> None:
    """Refuse a key that a document does not have."""
    for key in table:
        if key not in known:
            raise InvalidValue(key, table[key], f"expected {', '.join(known)}")
