"""Changes to docstrings before they appear in the reference.

Docstrings of `mgeo` have entries ``name : meaning``, in which numpydoc would interpret the meaning
as a type. To the docstrings of settings classes, a section on their fields is added.
"""

import dataclasses
import re
from typing import Any

from mgeo_attitude.settings.base import Settings, build_schema, get_fields
from mgeo_attitude.settings.schema_description import describe_schema
from sphinx.application import Sphinx
from sphinx.domains.python import PyObject

_SECTION = re.compile(r"(Parameters|Returns|Raises|Attributes|Yields)$")
_ENTRY = re.compile(r"(\S.*?) : (.+)$")


def convert_entries(lines: list[str]) -> list[str]:
    """Return the lines with each entry ``name : meaning`` as a name and an indented meaning.

    An entry whose second line is indented and begins a sentence has a type, and does not change.
    """
    found: list[str] = []
    in_section = False
    for i, line in enumerate(lines):
        if i + 1 < len(lines) and lines[i + 1].startswith("---"):
            in_section = _SECTION.match(line) is not None
        entry = _ENTRY.match(line) if in_section else None
        after = lines[i + 1] if i + 1 < len(lines) else ""
        if entry and not re.match(r"\s+[A-Z]", after):
            found += [entry[1], f"    {entry[2]}"]
        else:
            found.append(line)
    return found


def describe_fields(cls: type[Settings]) -> list[str]:
    """Return a section on the fields of a settings class."""
    found = ["", "Parameters", "----------"]
    for name in get_fields(cls):
        schema = build_schema(cls)["properties"][name]
        default = f"; default {schema['default']!r}" if "default" in schema else ""
        found += [f"{name} : {describe_schema(schema)}", f"    {schema['description']}{default}"]
    return found


def process_docstring(
    app: Sphinx, what: str, name: str, obj: Any, options: Any, lines: list[str]
) -> None:
    if name.partition(".")[0] == "mgeo":
        lines[:] = convert_entries(lines)
    if _is_settings(obj):
        lines += describe_fields(obj)


def process_signature(
    app: Sphinx, what: str, name: str, obj: Any, options: Any, given: str, returned: str
) -> tuple[str, str] | None:
    """Return an empty signature for settings, whose section on fields contains the defaults."""
    return ("", "") if _is_settings(obj) else None


def _is_settings(obj: Any) -> bool:
    return isinstance(obj, type) and issubclass(obj, Settings) and dataclasses.is_dataclass(obj)


def setup(app: Sphinx) -> dict[str, Any]:
    """Connect both functions, and omit links of attributes, which may lead to another class."""
    for field in PyObject.doc_field_types:
        if field.name == "variable":
            field.rolename = field.typerolename = ""
    app.connect(
        "autodoc-process-docstring", process_docstring, priority=400
    )  # before napoleon, at 500
    app.connect("autodoc-process-signature", process_signature)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
