"""Figures of a comparison."""

from __future__ import annotations

from typing import TYPE_CHECKING

import plotly.graph_objects as go

from mgeo.figures.comparison.anytime import anytime_figure
from mgeo.figures.comparison.attainment import attainment_figure
from mgeo.figures.comparison.boxes import boxes_figure
from mgeo.figures.comparison.difference import difference_figure
from mgeo.figures.comparison.each import each_figure
from mgeo.figures.comparison.fronts import fronts_figure
from mgeo.figures.comparison.ranks import ranks_figure

if TYPE_CHECKING:
    from mgeo.studies.comparison import Comparison

RIVALS = 5  # each adds up to 1 MB to a page

__all__ = [
    "RIVALS",
    "anytime_figure",
    "attainment_figure",
    "boxes_figure",
    "comparison_figures",
    "difference_figure",
    "each_figure",
    "fronts_figure",
    "ranks_figure",
]


def comparison_figures(comparison: Comparison) -> dict[str, go.Figure]:
    """All that can be drawn: anytime, boxes, fronts, each, attainment, difference.

    Fronts are drawn of two or three objectives, one by one and their attainment of two, if there
    are any. The difference is that of the best algorithm with a front and each of the `RIVALS`
    next ones.
    """
    figures = {"anytime": anytime_figure(comparison), "boxes": boxes_figure(comparison)}
    if not any(len(record.front) for record in comparison.records.values()):
        return figures
    if comparison.problem.n_obj in (2, 3):
        figures["fronts"] = fronts_figure(comparison)
    if comparison.problem.n_obj == 2:
        figures["each"] = each_figure(comparison)
        figures["attainment"] = attainment_figure(comparison)
        best, *others = (n for n in comparison.order() if any(map(len, comparison.fronts(n))))
        if others:
            figures["difference"] = difference_figure(comparison, best, others[:RIVALS])
    return figures
