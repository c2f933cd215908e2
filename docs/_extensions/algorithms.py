"""The directive ``algorithms``: a table of all algorithms, from the registry."""

from typing import Any

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from mgeo.runs.registry import RECORDS


def markdown() -> str:
    """Return one row for each algorithm of mgeo and of pymoo."""
    rows = (f"| `{each.name}` | {each.label} | {each.description} |" for each in RECORDS)
    return "\n".join(["| name | algorithm | description |", "| --- | --- | --- |", *rows])


class Algorithms(SphinxDirective):
    """The table, where it stands."""

    def run(self) -> list[nodes.Node]:
        return self.parse_text_to_nodes(markdown())


def setup(app: Sphinx) -> dict[str, Any]:
    app.add_directive("algorithms", Algorithms)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
