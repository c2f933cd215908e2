"""All figures of a comparison."""

from __future__ import annotations

from typing import TYPE_CHECKING

from mgeo.studies.figures.fronts import (
    attainment_figure,
    difference_figure,
    each_figure,
    fronts_figure,
)
from mgeo.studies.figures.indicators import anytime_figure, boxes_figure

if TYPE_CHECKING:
    import plotly.graph_objects as go

    from mgeo.studies.results import Results

_RIVALS = 5  # each adds up to 1 MB to a page


def comparison_figures(results: Results) -> dict[str, go.Figure]:
    """All that can be drawn: anytime, boxes, fronts, each, attainment, difference.

    Fronts are drawn of two or three objectives, one by one and their attainment of two, if there
    are any. The difference is that of the best algorithm with a front and each of the five next.
    """
    figures = {"anytime": anytime_figure(results), "boxes": boxes_figure(results)}
    ranked = [name for name in results.order() if any(map(len, results.fronts(name)))]
    if not ranked:
        return figures
    if results.problem.n_obj in (2, 3):
        figures["fronts"] = fronts_figure(results)
    if results.problem.n_obj == 2:
        figures["each"] = each_figure(results)
        figures["attainment"] = attainment_figure(results)
        if len(ranked) > 1:
            figures["difference"] = difference_figure(results, ranked[0], ranked[1 : _RIVALS + 1])
    return figures
