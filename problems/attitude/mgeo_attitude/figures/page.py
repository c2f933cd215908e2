"""One HTML page of several figures that opens without a network."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

import plotly.graph_objects as go

_CONFIG = {"responsive": True, "displaylogo": False, "showSendToCloud": False}


def page(figures: Sequence[go.Figure], title: str) -> str:
    """The figures below one another; the plotting library is inside, once.

    The same figures always give the same text.
    """
    bodies = [
        figure.to_html(
            full_html=False,
            include_plotlyjs=index == 0,
            config=_CONFIG,
            div_id=f"figure-{index + 1}",  # plotly would draw a random one
        )
        for index, figure in enumerate(figures)
    ]
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f"<title>{escape(title)}</title>\n<style>body {{ margin: 0 }}</style>\n"
        f"</head>\n<body>\n{chr(10).join(bodies)}\n</body>\n</html>\n"
    )
