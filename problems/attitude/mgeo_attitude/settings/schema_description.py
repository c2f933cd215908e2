"""Descriptions of JSON Schemas in English, for error messages, comments and reference pages."""

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
_BOUNDS = {"exclusiveMinimum": ">", "minimum": ">=", "exclusiveMaximum": "<", "maximum": "<="}


def describe_schema(schema: Schema) -> str:
    """Return an English description of a JSON Schema, such as ``a number > 0 [deg]``."""
    unit = f" [{schema['unit']}]" if "unit" in schema else ""
    return f"{_describe_type(schema)}{unit}"


def _describe_type(schema: Schema) -> str:
    if "anyOf" in schema:
        alternatives = dict.fromkeys(map(describe_schema, schema["anyOf"]))
        return " or ".join(sorted(alternatives, key="nothing".__ne__))
    if "enum" in schema or "const" in schema:
        return "one of " + ", ".join(map(repr, schema.get("enum", [schema.get("const")])))
    if "pattern" in schema:
        return f"a string that matches {schema['pattern']}"
    if schema.get("format") == "date-time":
        return "a date and time with UTC offset, such as 2018-06-05T00:00:00Z"
    if schema.get("type") == "array":
        bound = "" if "maxItems" in schema else "or more "
        count = f"{schema['minItems']} {bound}" if "minItems" in schema else ""
        entry = schema.get("items") or schema.get("prefixItems", [{}])[0]
        return f"a list of {count}values, each {describe_schema(entry)}"
    kind = _TYPES.get(schema.get("type", "object" if "$ref" in schema else ""), "anything")
    bounds = (f"{sign} {schema[key]:.12g}" for key, sign in _BOUNDS.items() if key in schema)
    return f"{kind} {' and '.join(bounds)}".rstrip()
