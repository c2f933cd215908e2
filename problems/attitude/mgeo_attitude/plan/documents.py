"""Common format of the JSON files of plans, calibrations and true parameters.

A JSON document starts with its ``format`` and ``version`` and contains the scenario. Entries that
follow from other entries are written for readers of the file only. They are ignored when the file
is read, and computed again.
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
    """Format of the JSON documents that store objects of one Python class.

    Attributes
    ----------
    name : str
        Value of the entry ``format``.
    version : int
        Value of the entry ``version``.
    defining_entries : function
        Returns the JSON entries that define an object, as a dict that starts with the scenario.
    build : function
        Constructs an object from a dict with the defining entries and from the scenario.
    derived_entries : function
        Returns the JSON entries that can be computed from the object, as a dict. They are written
        for readers of the file and ignored by `parse`.
    """

    name: str
    version: int
    defining_entries: Callable[[T], Mapping[str, Any]]
    build: Callable[[Mapping[str, Any], Scenario], T]
    derived_entries: Callable[[T], Mapping[str, Any]]

    def build_document(self, value: T) -> dict[str, Any]:
        """Convert an object to a dict that can be serialized as JSON.

        The dict has the keys ``format`` and ``version``, then the defining entries and the derived
        entries.
        """
        header = {"format": self.name, "version": self.version}
        return {**header, **self.defining_entries(value), **self.derived_entries(value)}

    def parse(self, text: str) -> T:
        """Parse JSON text and construct the object that it describes.

        Returns
        -------
        object

        Raises
        ------
        ValueError, TypeError
            If the text is not JSON, if its format or version differs, or if an entry is missing or
            invalid. The message names the key.
        """
        entries = parse_document(text, self.name, self.version)
        return self.build(entries, read_scenario(entries))


def serialize(document: Mapping[str, Any]) -> str:
    """Serialize a dict as indented JSON text, with floats in full precision.

    Returns
    -------
    str
        Text that ends with a newline.

    Raises
    ------
    ValueError
        If a float is not finite.
    """
    return json.dumps(document, indent=2, allow_nan=False, ensure_ascii=False) + "\n"


def parse_document(text: str, kind: str, version: int) -> dict[str, Any]:
    """Parse JSON text to a dict, and check the format and the version of the document.

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
    document = json.loads(text)
    name = document.get("format") if isinstance(document, dict) else None
    if name != kind:
        raise ValueError(f"format = {name!r:.80}: expected {kind!r}")
    if document.get("version") != version:
        raise ValueError(f"version = {document.get('version')!r:.80}: expected {version}")
    return document  # type: ignore[no-any-return]


def read_scenario(document: Mapping[str, Any]) -> Scenario:
    """Construct the scenario that a parsed JSON document contains under the key ``scenario``.

    The options must contain all keys without default; other keys have their default if missing. A
    preset is rejected, because its values may change between versions.

    Parameters
    ----------
    document : mapping
        Parsed document.

    Returns
    -------
    Scenario

    Raises
    ------
    ValueError, TypeError
        If the scenario is invalid; the message names the key, after ``scenario``.
    """
    options = get_entry(document, "scenario", dict)
    if "preset" in options:
        expected = "expected all keys instead of a preset, whose values may change between versions"
        raise InvalidValue("scenario.preset", options["preset"], expected)
    try:
        return Scenario.from_dict(options)
    except InvalidValue as error:
        raise error.prefix_key("scenario") from None


def read_document(path: Path | str, read: Callable[[str], T]) -> T:
    """Read a text file, and construct an object from its text.

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
        If the text is not UTF-8, or if `read` raises ValueError or TypeError. The message also
        names the file.
    """
    with convert_file_errors(path):
        return read(Path(path).read_text(encoding="utf-8"))
