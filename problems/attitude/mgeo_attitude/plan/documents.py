"""JSON documents of plans, calibrations and true parameters.

A document starts with its ``format`` and ``version`` and contains the scenario. Entries that follow
from other entries are informative: reading ignores them and computes them again.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, TypeVar

from mgeo.validation.entries import convert_file_errors, get_entry
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.settings.errors import InvalidValue

T = TypeVar("T")


@dataclass(frozen=True)
class DocumentFormat(Generic[T]):
    """A format of JSON documents.

    Attributes
    ----------
    name : str
        Value of the entry ``format``.
    version : int
        Value of the entry ``version``.
    defining_entries : function
        Return the entries that define an object, the scenario first.
    build : function
        Construct an object from a table with these entries and from their scenario.
    derived_entries : function
        Return the entries that follow from the others.
    """

    name: str
    version: int
    defining_entries: Callable[[T], Mapping[str, Any]]
    build: Callable[[Mapping[str, Any], Scenario], T]
    derived_entries: Callable[[T], Mapping[str, Any]]

    def build_document(self, thing: T) -> dict[str, Any]:
        """Return all entries of an object's document."""
        first = {"format": self.name, "version": self.version}
        return {**first, **self.defining_entries(thing), **self.derived_entries(thing)}

    def parse(self, text: str) -> T:
        """Return the object that a document describes.

        Raises
        ------
        ValueError, TypeError
            If the text is not JSON, if its format or version differs, or if an entry is missing or
            invalid. The message names the key.
        """
        table = parse_table(text, self.name, self.version)
        return self.build(table, read_scenario(table))


def serialize(document: Mapping[str, Any]) -> str:
    """Serialize a document as JSON text, from which floats are read back exactly."""
    return json.dumps(document, indent=2, allow_nan=False, ensure_ascii=False) + "\n"


def parse_table(text: str, kind: str, version: int) -> dict[str, Any]:
    """Parse a document and check its format and version.

    Parameters
    ----------
    text : str
    kind : str
        Expected ``format``.
    version : int
        Expected ``version``.

    Raises
    ------
    ValueError
        If the text is not JSON, or if its format or version differs.
    """
    table = json.loads(text)
    name = table.get("format") if isinstance(table, dict) else None
    if name != kind:
        raise ValueError(f"format = {name!r:.80}: expected {kind!r}")
    if table.get("version") != version:
        raise ValueError(f"version = {table.get('version')!r:.80}: expected {version}")
    return table  # type: ignore[no-any-return]


def read_scenario(table: Mapping[str, Any]) -> Scenario:
    """Return the scenario of a document.

    The document must contain all keys instead of a preset, whose values may change between
    versions.

    Raises
    ------
    ValueError, TypeError
        If the scenario is invalid; the message names the key, after ``scenario``.
    """
    own = get_entry(table, "scenario", dict)
    if "preset" in own:
        whole = "expected all keys instead of a preset, whose values may change between versions"
        raise InvalidValue("scenario.preset", own["preset"], whole)
    try:
        return Scenario.from_dict(own)
    except InvalidValue as error:
        raise error.prefix_key("scenario") from None


def read_document(path: Path | str, read: Callable[[str], T]) -> T:
    """Apply `read` to the text of a file.

    Raises
    ------
    OSError
        If the file cannot be read.
    ValueError
        If `read` raises one; the message also names the file.
    """
    with convert_file_errors(path):
        return read(Path(path).read_text(encoding="utf-8"))
