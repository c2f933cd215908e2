"""Table of the objectives of the satellite problem, from their records.

The directive ``objectives`` writes it where it stands.
"""

from typing import Any

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective


def markdown() -> str:
    from mgeo_attitude.criteria.objectives import OBJECTIVES, TRACE_DESCRIPTION, TRACE_PREFIX

    rows = [
        (key, f"{each.description}{'' if each.unit == '-' else f' [{each.unit}]'}")
        for key, each in OBJECTIVES.items()
    ]
    rows.append((f"{TRACE_PREFIX}BLOCK,BLOCK...", TRACE_DESCRIPTION))
    lines = ["| name | minimizes |", "| --- | --- |"]
    return "\n".join([*lines, *(f"| `{key}` | {text} |" for key, text in rows)])


class Objectives(SphinxDirective):
    """The table of objectives."""

    def run(self) -> list[nodes.Node]:
        return self.parse_text_to_nodes(markdown())


def setup(app: Sphinx) -> dict[str, Any]:
    app.add_directive("objectives", Objectives)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
