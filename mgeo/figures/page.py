"""Pages that open without a network: the plotting library is inside the file."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import plotly.graph_objects as go
from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

HEIGHT = 560  # px, of a figure that names none
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


def page(figure: go.Figure, title: str) -> str:
    """One HTML page that shows the figure in the whole window and loads nothing.

    The same figure always gives the same text.
    """
    body = _div(figure, "figure", library=True, height="100vh")
    return render("figures/assets/shell.html", title=title, parts=[body])


def report_page(title: str, parts: Sequence[str | go.Figure]) -> str:
    """One HTML page of several figures and of HTML between them, which loads nothing.

    The same parts always give the same text.
    """
    written: list[Markup] = []
    drawn = 0
    for part in parts:
        if isinstance(part, str):
            written.append(Markup(part))
            continue
        height = f"{part.layout.height or HEIGHT}px"
        written.append(_div(part, f"figure{drawn}", library=not drawn, height=height))
        drawn += 1
    return render("figures/assets/report.html", title=title, parts=written)


def _div(figure: go.Figure, name: str, *, library: bool, height: str) -> Markup:
    text: str = figure.to_html(
        full_html=False,
        include_plotlyjs=library,
        config=_CONFIG,
        div_id=name,  # plotly would draw a random one
        default_height=height,
    )
    return Markup(text)
