"""Common format of the JSON files of plans, calibrations and true parameters.

A document starts with its ``format`` and ``version`` and contains the scenario. Entries that follow
from other entries are written for readers of the file only; they are ignored and computed again
when the file is read.
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
    """Format of one kind of JSON document, with functions that convert objects to entries and
    back.

    Attributes
    ----------
    name : str
        Value of the entry ``format``.
    version : int
        Value of the entry ``version``.
    defining_entries : function
        Returns the entries that define an object, as a dict that starts with the scenario.
    build : function
        Constructs an object from a dict with the defining entries and from the scenario.
    derived_entries : function
        Returns the entries that follow from the defining entries, as a dict.
    """

    name: str
    version: int
    defining_entries: Callable[[T], Mapping[str, Any]]
    build: Callable[[Mapping[str, Any], Scenario], T]
    derived_entries: Callable[[T], Mapping[str, Any]]

    def build_document(self, value: T) -> dict[str, Any]:
        """Return the JSON document of an object as a dict: format, version and all entries."""
        header = {"format": self.name, "version": self.version}
        return {**header, **self.defining_entries(value), **self.derived_entries(value)}

    def parse(self, text: str) -> T:
        """Construct the object that a JSON text describes.

        Returns
        -------
        object

        Raises
        ------
        ValueError, TypeError
            If the text is not JSON, if its format or version differs, or if an entry is missing or
            invalid. The message names the key.
        """
        entries = parse_table(text, self.name, self.version)
        return self.build(entries, read_scenario(entries))


def serialize(document: Mapping[str, Any]) -> str:
    """Return a dict as JSON text, with floats in full precision.

    Returns
    -------
    str
    """
    return json.dumps(document, indent=2, allow_nan=False, ensure_ascii=False) + "\n"


def parse_table(text: str, kind: str, version: int) -> dict[str, Any]:
    """Parse a JSON document to a dict, and check its entries ``format`` and ``version``.

    Parameters
    ----------
    text : str
    kind : str
        Expected ``format``.
    version : int
        Expected ``version``.

    Returns
    -------
    dict

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
    """Construct the scenario from the entry ``scenario`` of a parsed document.

    The entry must contain all keys of the scenario. A preset is rejected, because its values may
    change between versions.

    Parameters
    ----------
    table : mapping
        Parsed document.

    Returns
    -------
    Scenario

    Raises
    ------
    ValueError, TypeError
        If the scenario is invalid; the message names the key, after ``scenario``.
    """
    options = get_entry(table, "scenario", dict)
    if "preset" in options:
        expected = "expected all keys instead of a preset, whose values may change between versions"
        raise InvalidValue("scenario.preset", options["preset"], expected)
    try:
        return Scenario.from_dict(options)
    except InvalidValue as error:
        raise error.prefix_key("scenario") from None


def read_document(path: Path | str, read: Callable[[str], T]) -> T:
    """Read a text file, and return the object that a parsing function constructs from the text.

    Parameters
    ----------
    path : path
    read : function
        Constructs the object from the text, such as `from_json`.

    Returns
    -------
    object
        Result of `read`.

    Raises
    ------
    OSError
        If the file cannot be read.
    ValueError
        If `read` raises one; the message also names the file.
    """
    with convert_file_errors(path):
        return read(Path(path).read_text(encoding="utf-8"))
