"""Pages that open without a network: the plotting library is inside the file."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

import plotly.graph_objects as go

HEIGHT = 560  # px, of a figure that names none
_STYLE = """
body { margin: 2rem auto; padding: 0 1rem; max-width: 1200px;
  font: 15px/1.5 "Open Sans", verdana, arial, sans-serif; color: #222 }
table { border-collapse: collapse; margin: 1rem 0; display: block; overflow-x: auto;
  white-space: nowrap }
th, td { padding: 0.3rem 0.8rem; border-bottom: 1px solid #e3e6ea; text-align: right }
th:first-child, td:first-child { text-align: left }
.note { color: #555 } .error { color: #a00 }
pre { background: #f5f6f8; padding: 1rem; overflow-x: auto; font-size: 13px }
"""
_CONFIG = {"responsive": True, "displaylogo": False, "showSendToCloud": False}


def page(figure: go.Figure, title: str) -> str:
    """One HTML page that shows the figure in the whole window and loads nothing.

    The same figure always gives the same text.
    """
    body = _div(figure, "figure", library=True, height="100vh")
    return _document(title, "body { margin: 0 }", body)


def report_page(title: str, parts: Sequence[str | go.Figure]) -> str:
    """One HTML page of several figures and of HTML between them, which loads nothing.

    The same parts always give the same text.
    """
    written: list[str] = []
    drawn = 0
    for part in parts:
        if isinstance(part, str):
            written.append(part)
            continue
        height = f"{part.layout.height or HEIGHT}px"
        written.append(_div(part, f"figure{drawn}", library=not drawn, height=height))
        drawn += 1
    return _document(title, _STYLE, "\n".join(written))


def _div(figure: go.Figure, name: str, *, library: bool, height: str) -> str:
    text: str = figure.to_html(
        full_html=False,
        include_plotlyjs=library,
        config=_CONFIG,
        div_id=name,  # plotly would draw a random one
        default_height=height,
    )
    return text


def _document(title: str, style: str, body: str) -> str:
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f"<title>{escape(title)}</title>\n<style>{style}</style>\n"
        f"</head>\n<body>\n{body}\n</body>\n</html>\n"
    )
