"""Docstrings of `mgeo` as numpydoc has them, so that Sphinx reads a parameter's meaning as such.

They say ``name : meaning`` in a line or more; numpydoc would take the meaning for a type.
"""

import re
from typing import Any

from sphinx.application import Sphinx

_SECTION = re.compile(r"(Parameters|Returns|Raises|Attributes|Yields)$")
_ENTRY = re.compile(r"(\S.*?) : (.+)$")


def numpydoc(lines: list[str]) -> list[str]:
    """Lines with each ``name : meaning`` moved to ``name`` and an indented meaning.

    An entry whose second line is indented and begins a sentence has a type, and stays.
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


def process(app: Sphinx, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    if name.partition(".")[0] == "mgeo":
        lines[:] = numpydoc(lines)


def setup(app: Sphinx) -> dict[str, Any]:
    app.connect("autodoc-process-docstring", process, priority=400)  # before napoleon, at 500
    return {"parallel_read_safe": True, "parallel_write_safe": True}
