"""Pages that open without a network: the plotting library is inside the file."""

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

LIBRARY = "plotly.min.js"  # file of the plotting library, beside pages that share it
_TITLE = 35  # px of a figure's margin that its title takes
_CONFIG = {"responsive": True, "displaylogo": False, "showSendToCloud": False}
_TEMPLATES = Environment(
    loader=PackageLoader("mgeo", ""),
    autoescape=True,
    undefined=StrictUndefined,
    trim_blocks=True,
    lstrip_blocks=True,
    keep_trailing_newline=True,
)


def render(template: str, **values: Any) -> str:
    """HTML of a template, a path below `mgeo`; of the values all that is no `Markup` is text."""
    return _TEMPLATES.get_template(template).render(values)


def page(figure: go.Figure, title: str, note: str = "") -> str:
    """Return one HTML page that shows the figure in the whole window and loads nothing.

    The same figure always gives the same text. The `note` stands above it.
    """
    body, heading = _drawn(figure, height="100%")
    return render("figures/assets/page.html", title=title, heading=heading, note=note, figure=body)


def report_page(title: str, parts: Sequence[str | go.Figure], library: bool | str = True) -> str:
    """Return one HTML page of several figures and of HTML between them, which loads nothing.

    The same parts always give the same text. For many pages that stay together, `library` is the
    path from the page to the file of `LIBRARY`, which all of them share.
    """
    written: list[Markup] = []
    drawn = 0
    for part in parts:
        if isinstance(part, str):
            written.append(Markup(part))
            continue
        figure, heading = _drawn(part, f"figure{drawn}", library if not drawn else False)
        written.append(Markup(render("figures/assets/heading.html", heading=heading)) + figure)
        drawn += 1
    return render("figures/assets/report.html", title=title, parts=written)


def drawing(figure: go.Figure) -> Markup:
    """Return a figure as a part of a page of one's own, with the scripts of ``scripts.html``."""
    return _drawn(figure)[0]


def _drawn(
    figure: go.Figure, name: str = "figure", library: bool | str = True, height: str | None = None
) -> tuple[Markup, list[str]]:
    """Return a figure without its title, and the title's lines: a page breaks them where it must.

    Parameters
    ----------
    name
        Identity of its element.
    library
        Whether the plotting library is inside, or the path to its file.
    """
    tree: dict[str, Any] = figure.to_dict()  # a copy that nobody validates once more
    layout = tree["layout"]
    text = layout.get("title", {}).get("text") or ""
    plain = (unescape(re.sub("<[^>]*>", "", line)).strip() for line in re.split("<br ?/?>", text))
    lines = [line for line in plain if line]
    if lines:
        del layout["title"]
        margin = layout.setdefault("margin", {})
        margin["t"] = max(margin.get("t", 100) - _TITLE, 30)  # 100 is plotly's own
    html: str = pio.to_html(
        tree,
        validate=False,
        full_html=False,
        include_plotlyjs=library,
        config=_CONFIG,
        div_id=name,  # plotly would draw a random one
        default_height=height or f"{layout.get('height') or PAGE_HEIGHT}px",
    )
    return Markup(html), lines
