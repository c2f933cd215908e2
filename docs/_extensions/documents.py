"""Directive ``document NAME``: tables of the keys of a JSON document.

``mgeo schema`` lists the names.
"""

import re
from collections.abc import Iterator
from typing import Any

from docutils import nodes
from keys import find_references
from mgeo_attitude.settings.schema_description import describe_schema
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from mgeo.validation.documents import collect_documents

_HEAD = ["| key | type | unit | meaning |", "| --- | --- | --- | --- |"]


def format_document(name: str) -> str:
    """Return a table of the top-level keys of a document, and a table for each object in it."""
    schema = collect_documents()[name].build_schema()
    parts = [_format_table(schema)]
    shown: set[str] = set()
    waiting = list(_objects("", schema))
    while waiting:
        path, definition = waiting.pop(0)
        if definition in shown:
            continue
        shown.add(definition)
        table = schema["$defs"][definition]
        parts += [f"**`{path}`** {table.get('description', '')}", _format_table(table)]
        waiting += _objects(f"{path}.", table)
    return "\n\n".join(parts) + "\n"


def _format_table(schema: Any) -> str:
    required = schema.get("required", ())
    rows = []
    for key, entry in schema["properties"].items():
        optional = "" if key in required or "default" in entry else "; optional"
        text = entry["description"].replace("|", r"\|")
        rows.append(
            f"| `{key}` | {_describe_type(entry)}{optional} | {entry.get('unit', '')} | {text} |"
        )
    return "\n".join([*_HEAD, *rows])


def _describe_type(entry: Any) -> str:
    if "anyOf" in entry:
        return " or ".join(_describe_type(each) for each in entry["anyOf"])
    if "$ref" in entry:
        return "object"
    if entry.get("type") == "array":
        return f"list of {_plural(_describe_type(entry['items']))}"
    if isinstance(entry.get("additionalProperties"), dict):
        return f"object of {_plural(_describe_type(entry['additionalProperties']))}"
    if entry.get("type") == "object":
        return "object"
    if entry.get("format") == "date-time":
        return "date and time"
    if "const" in entry or "enum" in entry:
        return describe_schema(entry).replace("True", "true").replace("'", '"')
    return {"null": "null", None: "any"}.get(entry.get("type"), entry.get("type"))


def _plural(text: str) -> str:
    return re.sub(r"^(object|list|string|number|integer|boolean)", r"\1s", text)


def _objects(above: str, schema: Any) -> Iterator[tuple[str, str]]:
    """Yield the path and the definition of each object in a schema."""
    for key, entry in schema["properties"].items():
        ending = "[]" if entry.get("type") == "array" else ""
        for definition in find_references(entry):
            yield f"{above}{key}{ending}", definition


class DocumentTables(SphinxDirective):
    """Tables of the keys of one JSON document."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        return self.parse_text_to_nodes(format_document(self.arguments[0]))


def setup(app: Sphinx) -> dict[str, Any]:
    app.add_directive("document", DocumentTables)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
