"""JSON Schema in words, for error messages, comments in files and reference pages."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

Schema = Mapping[str, Any]

_TYPES = {
    "boolean": "true or false",
    "string": "a string",
    "object": "a table",
    "null": "nothing",
    "number": "a number",
    "integer": "an integer",
}


def describe(schema: Schema) -> str:
    """Return what a schema takes: ``a number in [0, 1)``, ``nothing or a number > 0 [deg]``."""
    unit = f" [{schema['unit']}]" if "unit" in schema else ""
    return f"{_describe(schema)}{unit}"


def entry_of(schema: Schema, place: int | str) -> Schema | None:
    """Return the schema of an entry of a list or mapping; None for another place in a union."""
    if "anyOf" in schema:  # a list, or nothing
        lists = [each for each in schema["anyOf"] if each.get("type") in ("array", "object")]
        nullable = {"type": "null"} in schema["anyOf"] and len(schema["anyOf"]) == 2
        found = entry_of(lists[0], place) if lists and nullable else None
    elif isinstance(place, str):
        found = schema.get("additionalProperties") or None
    else:
        entries = schema.get("prefixItems", [])
        found = entries[place] if place < len(entries) else schema.get("items")
    unit = {"unit": schema["unit"]} if "unit" in schema else {}
    return None if found is None else {**found, **unit}


def _describe(schema: Schema) -> str:
    if "anyOf" in schema:
        words = dict.fromkeys(map(describe, schema["anyOf"]))
        return " or ".join(sorted(words, key="nothing".__ne__))
    if "enum" in schema or "const" in schema:
        return "one of " + ", ".join(map(repr, schema.get("enum", [schema.get("const")])))
    if schema.get("format") == "date-time":
        return "a date and time with UTC offset, such as 2018-06-05T00:00:00Z"
    if schema.get("type") == "array":
        fixed = schema.get("minItems") == schema.get("maxItems") is not None
        count = f"{schema['minItems']} x " if fixed else ""
        entry = schema.get("items") or schema.get("prefixItems", [{}])[0]
        return f"a list of {count}({describe(entry)})"
    limits = _range(schema)
    if schema.get("type") == "number" and not limits:
        return "a finite number"
    kind = schema.get("type", "object" if "$ref" in schema else "")
    return f"{_TYPES.get(kind, 'anything')}{limits}"


def _range(schema: Schema) -> str:
    """Return ``in [0, 1)`` or ``> 0`` after a blank; empty for a number without bounds."""
    low = schema.get("exclusiveMinimum", schema.get("minimum"))
    high = schema.get("exclusiveMaximum", schema.get("maximum"))
    opened, closed = "exclusiveMinimum" in schema, "exclusiveMaximum" in schema
    if low is not None and high is not None:
        return f" in {'(' if opened else '['}{low:.12g}, {high:.12g}{')' if closed else ']'}"
    if low is not None:
        return f" {'>' if opened else '>='} {low:.12g}"
    return "" if high is None else f" {'<' if closed else '<='} {high:.12g}"
