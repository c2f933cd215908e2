"""HTML page of a review document with figures."""

from __future__ import annotations

from collections.abc import Mapping

import plotly.graph_objects as go
from markupsafe import Markup

from mgeo.figures.page import convert_to_html, render
from mgeo.plugins.review import Review


def render_review_page(review: Review, figures: Mapping[str, go.Figure]) -> str:
    """Return a review document as an HTML page that works without a network.

    Sections of the first page come first, followed by details that are closed on screen and open
    in print. Equal documents give equal pages.

    Parameters
    ----------
    review : Review
    figures : mapping of str to plotly.graph_objects.Figure
        Figures by the key of the section that each figure follows.
    """
    html_figures: dict[str, tuple[Markup, list[str]]] = {}
    for section in review.sections:
        if section.key in figures:
            html_figures[section.key] = convert_to_html(
                figures[section.key], f"figure-{section.key}", library=not html_figures
            )
    return render(
        "report/assets/review_page.html",
        title=review.title,
        review=review,
        figures=html_figures,
    )
