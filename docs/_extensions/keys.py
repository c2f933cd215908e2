"""Directive ``keys``: tables of all keys of a file format, generated from its JSON Schema.

``keys scenario``, ``keys study`` and ``keys mapping`` have one table of the top-level keys, and a
section for each TOML table.
"""

import json
import re
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from docutils import nodes
from mgeo_attitude.settings.schema_description import describe_schema
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

Schema = Mapping[str, Any]


def scenario() -> Schema:
    from mgeo_attitude.scenario import build_scenario_schema

    return build_scenario_schema()


def study() -> Schema:
    from mgeo.studies.schema import build_study_schema

    return json.loads(build_study_schema())


def mapping() -> Schema:
    from mgeo_attitude.settings.base import build_schema
    from mgeo_calibration import TelemetryMapping

    return build_schema(TelemetryMapping)


SCHEMAS: Mapping[str, Callable[[], Schema]] = {
    "scenario": scenario,
    "study": study,
    "mapping": mapping,
}


def format_keys(schema: Schema) -> str:
    """Return a table of the top-level keys, and a section for each TOML table in the order in which
    the keys refer to the tables.
    """
    parts = ["## Top-level keys", _format_table(schema)]
    for name, key in _find_paths(schema).items():
        definition = schema["$defs"][name]
        parts.append(f"## `{key}`, {_split_name(name)}")
        parts += [
            text for text in (definition.get("description", ""), _format_table(definition)) if text
        ]
    return "\n\n".join(parts) + "\n"


def _format_table(schema: Schema) -> str:
    required = schema.get("required") or schema.get("anyOf", [{}])[-1].get("required", ())
    rows = ["| key | type and range | default | meaning |", "| --- | --- | --- | --- |"]
    for key, value in schema.get("properties", {}).items():
        default = "required" if key in required else _format_default(value)
        kind = describe_schema(value).removeprefix("nothing or ")  # The default is "none".
        cells = (f"`{key}`", kind, default, value.get("description", ""))
        rows.append(f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in cells)} |")
    return "\n".join(rows)


def _find_paths(schema: Schema) -> dict[str, str]:
    """Return, for each definition, the TOML header of the first table that uses it."""
    found: dict[str, str] = {}
    waiting = [("", schema)]
    for above, table in waiting:
        for key, value in table.get("properties", {}).items():
            listed = "items" in value or value.get("type") == "array"
            full = f"{above}{key}"
            for name in find_references(value):
                if name not in found:
                    found[name] = f"[[{full}]]" if listed else f"[{full}]"
                    waiting.append((f"{full}.", schema["$defs"][name]))
    return found


def find_references(value: Any) -> Iterator[str]:
    if isinstance(value, Mapping):
        if "$ref" in value:
            yield value["$ref"].rpartition("/")[2]
        for part in value.values():
            yield from find_references(part)
    elif isinstance(value, list):
        for part in value:
            yield from find_references(part)


def _format_default(value: Schema) -> str:
    if "default" not in value:
        return ""
    default = value["default"]
    return "none" if default is None else f"`{json.dumps(default, ensure_ascii=False)}`"


def _split_name(name: str) -> str:
    """Return the words of a class name: "TLE orbit" for `TLEOrbit`."""
    parts = re.findall(r"[A-Z]+(?=[A-Z][a-z])|[A-Z][a-z]+|[A-Z]+|\d+", name)
    return " ".join(part if part.isupper() else part.lower() for part in parts)


class Keys(SphinxDirective):
    """Tables of the keys of one file format."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        (kind,) = self.arguments
        lines = format_keys(SCHEMAS[kind]()).splitlines()
        return self.parse_text_to_nodes("\n".join(lines), allow_section_headings=True)


def setup(app: Sphinx) -> dict[str, Any]:
    app.add_directive("keys", Keys)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
