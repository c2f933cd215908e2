"""The directive ``plotly``: an interactive figure, with the library served by the site itself.

Its argument names a function of `figures.py`, beside this file, that returns a plotly figure.
"""

from pathlib import Path
from typing import Any

import figures
from docutils import nodes
from plotly.offline import get_plotlyjs
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

LIBRARY = "_static/plotly.min.js"
_CONFIG = {"responsive": True, "displaylogo": False, "showSendToCloud": False}


class PlotlyFigure(SphinxDirective):
    """One figure, drawn where it stands."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        (name,) = self.arguments
        for source in figures.SOURCES:
            self.env.note_dependency(str(source))
        text = figures.FIGURES[name]().to_html(
            full_html=False,
            include_plotlyjs=False,
            config=_CONFIG,
            div_id=f"figure-{name}",  # plotly would draw a random one
        )
        # Here and not by `add_js_file`: the theme would load it after the figure wants it.
        library = "../" * self.env.docname.count("/") + LIBRARY
        script = f'<script src="{library}"></script>'
        return [nodes.raw("", f'<div class="plotly-box">{script}{text}</div>', format="html")]


def write_library(app: Sphinx, error: Exception | None) -> None:
    if error is None and app.builder.format == "html":
        (Path(app.outdir) / LIBRARY).write_text(get_plotlyjs(), encoding="utf-8")


def setup(app: Sphinx) -> dict[str, Any]:
    app.add_directive("plotly", PlotlyFigure)
    app.connect("build-finished", write_library)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
