"""The directive ``export-formats``: a table of the formats in which plans are exported."""

from typing import Any

from docutils import nodes
from mgeo_attitude.export_formats import FORMATS
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective


def markdown() -> str:
    """Return the table of the formats."""
    rows = ["| file | format | contents | needs |", "| --- | --- | --- | --- |"]
    for each in FORMATS:
        package = f"`{each.package}`" if each.package else ""
        rows.append(f"| `{each.suffix}` | {each.name} | {each.description} | {package} |")
    return "\n".join(rows)


class ExportFormats(SphinxDirective):
    """The table in place of the directive."""

    def run(self) -> list[nodes.Node]:
        """Return the table's nodes."""
        return self.parse_text_to_nodes(markdown())


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the directive."""
    app.add_directive("export-formats", ExportFormats)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
