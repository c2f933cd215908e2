"""JSON documents that read back: plans, calibrations, truths.

Each has its ``format`` and ``version`` first, and the scenario it belongs to. What follows from
these keys is written for people and other tools; on reading it is ignored and computed again.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, TypeVar

from mgeo.validation.entries import entry, errors_of
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.settings.errors import InvalidValue

T = TypeVar("T")


@dataclass(frozen=True)
class Form(Generic[T]):
    """A format of documents.

    Attributes
    ----------
    name, version : str, int
        Of the format.
    keys : function
        Return the entries from which the object is made again, the scenario first.
    made : function
        Return the object of a table with these entries, and of their scenario.
    consequences : function
        Return the entries that follow from the others.
    """

    name: str
    version: int
    keys: Callable[[T], Mapping[str, Any]]
    made: Callable[[Mapping[str, Any], Scenario], T]
    consequences: Callable[[T], Mapping[str, Any]]

    def document(self, thing: T) -> dict[str, Any]:
        """Return all entries of an object's document."""
        first = {"format": self.name, "version": self.version}
        return {**first, **self.keys(thing), **self.consequences(thing)}

    def read(self, text: str) -> T:
        """Return the object of a document.

        Raises
        ------
        ValueError, TypeError
            If the text is no JSON or of another format or version, or an entry is missing or
            invalid; the message names the key.
        """
        table = opened(text, self.name, self.version)
        return self.made(table, scenario_of(table))


def written(document: Mapping[str, Any]) -> str:
    """Return a document as text; floats by repr, so that they read back exactly."""
    return json.dumps(document, indent=2, allow_nan=False, ensure_ascii=False) + "\n"


def opened(text: str, kind: str, version: int) -> dict[str, Any]:
    """Return the table of a document.

    Raises
    ------
    ValueError
        If the text is no JSON, or of another format or version.
    """
    table = json.loads(text)
    found = table.get("format") if isinstance(table, dict) else None
    if found != kind:
        raise ValueError(f"format = {found!r:.80}: expected {kind!r}")
    if table.get("version") != version:
        raise ValueError(f"version = {table.get('version')!r:.80}: expected {version}")
    return table  # type: ignore[no-any-return]


def scenario_of(table: Mapping[str, Any]) -> Scenario:
    """Return the scenario of a document, which contains all keys: a preset's values may change.

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
    """Return the object that `read` makes of the text of a file.

    Raises
    ------
    OSError
        If the file cannot be read.
    ValueError
        Naming the file, and what `read` reports.
    """
    with errors_of(path):
        return read(Path(path).read_text(encoding="utf-8"))
