"""JSON documents that read back: plans, calibrations, truths.

Each has its ``format`` and ``version`` first, and the scenario it belongs to. What follows from
other keys is computed again on reading, and a document that says something else is refused.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, TypeVar

from mgeo.files.reading import entry, errors_of, parse_json, read_text
from mgeo_attitude.fields import InvalidValue
from mgeo_attitude.scenario import Scenario

T = TypeVar("T")

#: A plan of 100 maneuvers is far smaller.
MOST_BYTES = 64 * 2**20

#: Numbers that were computed again, perhaps by other libraries, may differ by this fraction.
TOLERANCE = 1e-6


def written(document: Mapping[str, Any]) -> str:
    """A document as text; floats by repr, so that they read back exactly."""
    return json.dumps(document, indent=2, allow_nan=False, ensure_ascii=False) + "\n"


def opened(text: str, kind: str, version: int) -> dict[str, Any]:
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
    if said != version or isinstance(said, bool):
        raise ValueError(f"version = {said!r:.80}: this package reads version {version}")
    return table  # type: ignore[no-any-return]


def scenario_of(table: Mapping[str, Any]) -> Scenario:
    """The scenario of a document.

    Raises
    ------
    ValueError, TypeError
        Naming the key, after ``scenario``.
    """
    try:
        return Scenario.from_dict(entry(table, "scenario", dict))
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


def check_keys(table: Mapping[str, Any], known: Iterable[str]) -> None:
    """Refuse a key that a document does not have.

    Raises
    ------
    InvalidValue
    """
    names = list(known)
    for key in table:
        if key not in names:
            raise InvalidValue(key, table[key], f"expected {', '.join(names)}")


def check_consequences(
    table: Mapping[str, Any], consequences: Mapping[str, Any], source: str
) -> None:
    """Refuse a document that says something else than what follows from a source in it.

    Raises
    ------
    ValueError, TypeError
        Naming the first key.
    """
    for key, expected in consequences.items():
        check_same(key, entry(table, key, type(expected)), expected, source)


def check_same(key: str, found: Any, expected: Any, source: str) -> None:
    """Refuse other data than follow from a source, naming the first key.

    Numbers may be off by `TOLERANCE`.

    Raises
    ------
    InvalidValue
    """
    if isinstance(expected, dict) and isinstance(found, dict) and found.keys() == expected.keys():
        for name in expected:
            check_same(f"{key}.{name}", found[name], expected[name], source)
        return
    if isinstance(expected, list) and isinstance(found, list) and len(found) == len(expected):
        for i, (one, other) in enumerate(zip(found, expected, strict=True)):
            check_same(f"{key}[{i}]", one, other, source)
        return
    if isinstance(expected, float) and type(found) in (int, float):
        # no fraction of a number that is zero but for rounding, as in a quaternion
        close = TOLERANCE * max(abs(expected), TOLERANCE)
        same = expected - close <= found <= expected + close
    else:
        same = type(found) is type(expected) and found == expected
    if not same:
        raise InvalidValue(key, found, f"expected {expected!r}, which follows from {source}")
