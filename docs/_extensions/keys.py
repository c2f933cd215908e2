"""Tables of all keys of a file, made from its JSON Schema when the site is built.

The directive ``keys scenario``, ``keys study`` or ``keys mapping`` writes a table of the top-level
keys, and a section for each table of the file below it.
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


def markdown(schema: Schema) -> str:
    """Return a table of the top-level keys of a file, and a section for each table of the file."""
    parts = ["## Top-level keys", _table(schema)]
    for name, key in _places(schema).items():
        definition = schema["$defs"][name]
        parts.append(f"## `{key}`, {_words(name)}")
        parts += [text for text in (definition.get("description", ""), _table(definition)) if text]
    return "\n\n".join(parts) + "\n"


def _table(schema: Schema) -> str:
    required = schema.get("required") or schema.get("anyOf", [{}])[-1].get("required", ())
    rows = ["| key | value | default | meaning |", "| --- | --- | --- | --- |"]
    for key, value in schema.get("properties", {}).items():
        default = "needed" if key in required else _default(value)
        kind = describe_schema(value).removeprefix("nothing or ")  # The default is "none".
        cells = (f"`{key}`", kind, default, value.get("description", ""))
        rows.append(f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in cells)} |")
    return "\n".join(rows)


def _places(schema: Schema) -> dict[str, str]:
    """Names of definitions and the key, as a file writes it, under which each is first found."""
    found: dict[str, str] = {}
    waiting = [("", schema)]
    for above, table in waiting:
        for key, value in table.get("properties", {}).items():
            listed = "items" in value or value.get("type") == "array"
            full = f"{above}{key}"
            for name in _references(value):
                if name not in found:
                    found[name] = f"[[{full}]]" if listed else f"[{full}]"
                    waiting.append((f"{full}.", schema["$defs"][name]))
    return found


def _references(value: Any) -> Iterator[str]:
    if isinstance(value, Mapping):
        if "$ref" in value:
            yield value["$ref"].rpartition("/")[2]
        for part in value.values():
            yield from _references(part)
    elif isinstance(value, list):
        for part in value:
            yield from _references(part)


def _default(value: Schema) -> str:
    if "default" not in value:
        return ""
    default = value["default"]
    return "none" if default is None else f"`{json.dumps(default, ensure_ascii=False)}`"


def _words(name: str) -> str:
    """`ManeuverBounds` as maneuver limits, `TLEOrbit` as TLE orbit."""
    parts = re.findall(r"[A-Z]+(?=[A-Z][a-z])|[A-Z][a-z]+|[A-Z]+|\d+", name)
    return " ".join(part if part.isupper() else part.lower() for part in parts)


class Keys(SphinxDirective):
    """The keys of one kind of file, where it stands."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        (kind,) = self.arguments
        lines = markdown(SCHEMAS[kind]()).splitlines()
        return self.parse_text_to_nodes("\n".join(lines), allow_section_headings=True)


def setup(app: Sphinx) -> dict[str, Any]:
    app.add_directive("keys", Keys)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
