"""Interactive figures, drawn by one copy of plotly's library that is part of the site.

The directive ``plotly NAME`` shows a figure of `figures.py`. The figures of executed cells are
output as JSON (``PLOTLY_RENDERER``) and shown in the same way: MyST-NB finds `Output` by the entry
point in the folder ``plotly_figures-1.0.dist-info``.
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


def build_figure_node(figure: Any, name: str, docname: str) -> nodes.raw:
    """Return the node of a figure, given as object or dict, on the page `docname`. The name must be
    unique on this page.
    """
    text = to_html(
        figure,
        full_html=False,
        include_plotlyjs=False,
        config=_CONFIG,
        div_id=f"figure-{name}",  # plotly would use a random identifier
        validate=False,
    )
    # With `add_js_file`, the theme would load the library after the script of the figure.
    library = "../" * docname.count("/") + LIBRARY
    script = f'<script src="{library}"></script>'
    named = f'<div role="figure" aria-label="{escape(format_label(figure))}">{text}</div>'
    fallback = "<noscript>This figure requires JavaScript.</noscript>"
    classes = "plotly-box" + (" fits-phone" if has_free_sides(figure) else "")
    return nodes.raw(
        "",
        f'<div class="{classes}">{script}{_build_caption(figure)}{named}{fallback}</div>',
        format="html",
    )


def has_free_sides(figure: Any) -> bool:
    """Return whether no legend is beside the plot, so that the plot fits a narrow screen."""
    layout = _layout(figure)
    return layout.get("showlegend") is False or layout.get("legend", {}).get("orientation") == "h"


def _build_caption(figure: Any) -> str:
    """Return the title as HTML, which replaces the title of the drawing on narrow screens, because
    it wraps.
    """
    text = _get_text(_layout(figure), "title", "text")
    return f'<p class="plotly-title" aria-hidden="true">{text}</p>' if text else ""


def _layout(figure: Any) -> dict[str, Any]:
    layout: dict[str, Any] = (figure if isinstance(figure, dict) else figure.to_plotly_json())[
        "layout"
    ]
    return layout


def format_label(figure: Any) -> str:
    """Return the title of a figure, or the titles of its axes if there is none."""
    layout = _layout(figure)

    def find_axis_title(direction: str) -> str:
        axes = sorted(key for key in layout if key.startswith(f"{direction}axis"))
        titles = [_get_text(layout, axis, "title", "text") for axis in axes]
        return next((_remove_tags(title) for title in titles if title), "")

    title = _remove_tags(_get_text(layout, "title", "text"))
    titles = [each for each in (find_axis_title("y"), find_axis_title("x")) if each]
    return title or " against ".join(titles) or "figure"


def _get_text(layout: dict[str, Any], *path: str) -> str:
    value: Any = layout
    for key in path:
        value = value.get(key) or {} if isinstance(value, dict) else {}
    return value if isinstance(value, str) else ""


def _remove_tags(text: str) -> str:
    return re.sub("<.*?>", " ", text).strip()


class PlotlyFigure(SphinxDirective):
    """Figure with the name that is the argument."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        import figures  # slow, because it imports the packages of the satellite problem

        (name,) = self.arguments
        for source in figures.SOURCES:
            self.env.note_dependency(str(source))
        return [build_figure_node(figures.FIGURES[name](), name, self.env.docname)]


class Output:
    """Renderer of the figures of executed cells."""

    mime_priority_overrides: ClassVar[Sequence[tuple[str, str, int | None]]] = [("*", MIME, 1)]

    @staticmethod
    def handle_mime(renderer: Any, data: Any, inline: bool) -> list[nodes.Element] | None:
        if inline or data.mime_type != MIME:
            return None
        env = renderer.renderer.sphinx_env
        name = f"{data.cell_index}-{data.output_index}"
        return [build_figure_node(data.content, name, env.docname)]


def write_library(app: Sphinx, error: Exception | None) -> None:
    if error is None and app.builder.format == "html":
        (Path(app.outdir) / LIBRARY).write_text(get_plotlyjs(), encoding="utf-8")


def setup(app: Sphinx) -> dict[str, Any]:
    os.environ["PLOTLY_RENDERER"] = "plotly_mimetype"  # for the kernels
    app.add_directive("plotly", PlotlyFigure)
    app.connect("build-finished", write_library)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
