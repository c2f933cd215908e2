"""Pages that open without a network: the plotting library is inside the file."""

from __future__ import annotations

from html import escape

import plotly.graph_objects as go

_CONFIG = {"responsive": True, "displaylogo": False}


def page(figure: go.Figure, title: str) -> str:
    """One HTML page that shows the figure in the whole window and loads nothing.

    The same figure always gives the same text.
    """
    body = figure.to_html(
        full_html=False,
        include_plotlyjs=True,
        config=_CONFIG,
        div_id="figure",  # plotly would draw a random one
        default_height="100vh",
    )
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f"<title>{escape(title)}</title>\n<style>body {{ margin: 0 }}</style>\n"
        f"</head>\n<body>\n{body}\n</body>\n</html>\n"
    )
