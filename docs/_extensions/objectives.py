"""Directive ``objectives``: table of the objectives of the satellite problem."""

from typing import Any

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective


def format_objectives() -> str:
    """Return a table with one row for each objective."""
    from mgeo_attitude.criteria.objectives import OBJECTIVES, TRACE_DESCRIPTION, TRACE_PREFIX

    rows = [
        (key, f"{each.description}{'' if each.unit == '-' else f' [{each.unit}]'}")
        for key, each in OBJECTIVES.items()
    ]
    rows.append((f"{TRACE_PREFIX}BLOCK,BLOCK...", TRACE_DESCRIPTION))
    lines = ["| name | minimizes |", "| --- | --- |"]
    return "\n".join([*lines, *(f"| `{key}` | {text} |" for key, text in rows)])


class Objectives(SphinxDirective):
    """Table of the objectives."""

    def run(self) -> list[nodes.Node]:
        return self.parse_text_to_nodes(format_objectives())


def setup(app: Sphinx) -> dict[str, Any]:
    app.add_directive("objectives", Objectives)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
