"""Interactive figures, drawn by one copy of plotly's library that the site itself serves.

The directive ``plotly`` draws where it stands what a function of `figures.py`, beside this file,
returns. A notebook's figures come as JSON (``PLOTLY_RENDERER``) and are drawn alike: `Output` is
found by MyST-NB through the entry point in the folder ``plotly_figures-1.0.dist-info``.
"""

import os
import re
from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import Any, ClassVar

from docutils import nodes
from plotly.io import to_html
from plotly.offline import get_plotlyjs
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

LIBRARY = "_static/plotly.min.js"
MIME = "application/vnd.plotly.v1+json"
_CONFIG = {"responsive": True, "displaylogo": False, "showSendToCloud": False}


def box(figure: Any, name: str, docname: str) -> nodes.raw:
    """A figure, or the dictionary of one, on the page `docname`; its name is unique there."""
    text = to_html(
        figure,
        full_html=False,
        include_plotlyjs=False,
        config=_CONFIG,
        div_id=f"figure-{name}",  # plotly would draw a random one
        validate=False,
    )
    # Here and not by `add_js_file`: the theme would load it after the figure wants it.
    library = "../" * docname.count("/") + LIBRARY
    script = f'<script src="{library}"></script>'
    named = f'<div role="figure" aria-label="{escape(label(figure))}">{text}</div>'
    without = f"<noscript>{escape(label(figure))}: a figure that needs JavaScript.</noscript>"
    classes = "plotly-box" + (" fits-phone" if has_free_sides(figure) else "")
    return nodes.raw("", f'<div class="{classes}">{script}{named}{without}</div>', format="html")


def has_free_sides(figure: Any) -> bool:
    """Return whether no legend is beside the plot, so that the plot fits a narrow screen."""
    layout = _layout(figure)
    return layout.get("showlegend") is False or layout.get("legend", {}).get("orientation") == "h"


def _layout(figure: Any) -> dict[str, Any]:
    layout: dict[str, Any] = (figure if isinstance(figure, dict) else figure.to_plotly_json())[
        "layout"
    ]
    return layout


def label(figure: Any) -> str:
    """What a figure shows: its title, or else one axis against the other."""
    layout = _layout(figure)

    def text(*path: str) -> str:
        value: Any = layout
        for key in path:
            value = value.get(key) or {} if isinstance(value, dict) else {}
        return re.sub("<.*?>", " ", value) if isinstance(value, str) else ""

    title = text("title", "text").strip()
    return title or f"{text('yaxis', 'title', 'text')} against {text('xaxis', 'title', 'text')}"


class PlotlyFigure(SphinxDirective):
    """One figure, drawn where it stands."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        import figures  # with all that computes

        (name,) = self.arguments
        for source in figures.SOURCES:
            self.env.note_dependency(str(source))
        return [box(figures.FIGURES[name](), name, self.env.docname)]


class Output:
    """A figure that a notebook shows."""

    mime_priority_overrides: ClassVar[Sequence[tuple[str, str, int | None]]] = [("*", MIME, 1)]

    @staticmethod
    def handle_mime(renderer: Any, data: Any, inline: bool) -> list[nodes.Element] | None:
        if inline or data.mime_type != MIME:
            return None
        env = renderer.renderer.sphinx_env
        return [box(data.content, f"{data.cell_index}-{data.output_index}", env.docname)]


def write_library(app: Sphinx, error: Exception | None) -> None:
    if error is None and app.builder.format == "html":
        (Path(app.outdir) / LIBRARY).write_text(get_plotlyjs(), encoding="utf-8")


def setup(app: Sphinx) -> dict[str, Any]:
    os.environ["PLOTLY_RENDERER"] = "plotly_mimetype"  # for the kernels
    app.add_directive("plotly", PlotlyFigure)
    app.connect("build-finished", write_library)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
