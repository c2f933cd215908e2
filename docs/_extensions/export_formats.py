"""Directive ``export-formats``: table of the formats in which plans are exported."""

from typing import Any

from docutils import nodes
from mgeo_attitude.export_formats import FORMATS
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective


def format_formats() -> str:
    """Return a table with one row for each format."""
    rows = ["| file | format | contents | needs |", "| --- | --- | --- | --- |"]
    for each in FORMATS:
        package = f"`{each.package}`" if each.package else ""
        rows.append(f"| `{each.suffix}` | {each.name} | {each.description} | {package} |")
    return "\n".join(rows)


class ExportFormats(SphinxDirective):
    """Table of the export formats."""

    def run(self) -> list[nodes.Node]:
        return self.parse_text_to_nodes(format_formats())


def setup(app: Sphinx) -> dict[str, Any]:
    app.add_directive("export-formats", ExportFormats)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
