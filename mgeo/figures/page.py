"""HTML pages of figures that work without a network, because they include the plotting library."""

from __future__ import annotations

import re
from collections.abc import Sequence
from html import unescape
from typing import Any

import plotly.graph_objects as go
import plotly.io as pio
from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from mgeo.figures.style import PAGE_HEIGHT
from mgeo.plugins.review import Section, find_column_kinds, format_cells

#: File name of the plotting library, if several pages share it.
LIBRARY_FILE = "plotly.min.js"
_TITLE_HEIGHT = 65  # Height of a figure's title [px].
_CONFIG = {"responsive": True, "displaylogo": False, "showSendToCloud": False}
_TEMPLATES = Environment(
    loader=PackageLoader("mgeo", ""),
    autoescape=True,
    undefined=StrictUndefined,
    trim_blocks=True,
    lstrip_blocks=True,
    keep_trailing_newline=True,
)


_TEMPLATES.globals |= {"format_cells": format_cells, "find_column_kinds": find_column_kinds}


def render(template: str, **values: Any) -> str:
    """Render a Jinja template as HTML. Values that are not `Markup` are escaped.

    Parameters
    ----------
    template : str
        Path of the template below the package `mgeo`.
    **values
        Variables of the template.
    """
    return _TEMPLATES.get_template(template).render(values)


def render_section(section: Section) -> Markup:
    """Return a section as HTML: its title, paragraphs, table and note."""
    macros: Any = _TEMPLATES.get_template("figures/assets/section.html").module
    return Markup(macros.render_section(section))


def render_figure_page(figure: go.Figure, title: str, note: str = "") -> str:
    """Return an HTML page with one figure that fills the window.

    Equal figures give equal pages.

    Parameters
    ----------
    figure : plotly.graph_objects.Figure
        Figure to show.
    title : str
        Title of the page.
    note : str
        Text above the figure.
    """
    body, heading = convert_to_html(figure, height="100%")
    return render("figures/assets/page.html", title=title, heading=heading, note=note, figure=body)


def render_report_page(
    title: str, parts: Sequence[str | go.Figure], library: bool | str = True
) -> str:
    """Return an HTML page that contains figures and HTML texts in the given order.

    Equal parts give equal pages.

    Parameters
    ----------
    title : str
        Title of the page.
    parts : sequence of str or plotly.graph_objects.Figure
        Figures and HTML texts, in their order on the page.
    library : bool or str
        Path from the page to the file `LIBRARY_FILE`, for pages that share the plotting library;
        True to include the library in the page.
    """
    html_parts: list[Markup] = []
    n_figures = 0
    for part in parts:
        if isinstance(part, str):
            html_parts.append(Markup(part))
            continue
        figure, heading = convert_to_html(
            part, f"figure{n_figures}", library if not n_figures else False
        )
        html_parts.append(Markup(render("figures/assets/heading.html", heading=heading)) + figure)
        n_figures += 1
    return render("figures/assets/report.html", title=title, parts=html_parts)


def render_figure(figure: go.Figure) -> Markup:
    """Return a figure as HTML for pages that include the template ``scripts.html``."""
    return convert_to_html(figure)[0]


def convert_to_html(
    figure: go.Figure, name: str = "figure", library: bool | str = True, height: str | None = None
) -> tuple[Markup, list[str]]:
    """Convert a figure without its title to HTML, and return the lines of the title separately.

    A page shows the title as a heading, which wraps.

    Parameters
    ----------
    figure : plotly.graph_objects.Figure
        Figure to convert.
    name : str
        ID of the HTML element.
    library : bool or str
        Whether to include the plotting library, or the path to its file.
    height : str, optional
        Height in CSS. Default: the height of the figure.
    """
    tree: dict[str, Any] = figure.to_dict()  # A copy, because the title is removed below.
    layout = tree["layout"]
    text = layout.get("title", {}).get("text") or ""
    plain = (unescape(re.sub("<[^>]*>", "", line)).strip() for line in re.split("<br ?/?>", text))
    lines = [line for line in plain if line]
    if lines:
        del layout["title"]
        margin = layout.setdefault("margin", {})
        margin["t"] = max(margin.get("t", 100) - _TITLE_HEIGHT, 30)  # 100 is plotly's default.
    html: str = pio.to_html(
        tree,
        validate=False,
        full_html=False,
        include_plotlyjs=library,
        config=_CONFIG,
        div_id=name,  # plotly would use a random ID.
        default_height=height or f"{layout.get('height') or PAGE_HEIGHT}px",
    )
    return Markup(html), lines
