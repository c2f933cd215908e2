"""Figures of a comparison: indicators over evaluations and runs, fronts, attainment, ranks."""

from mgeo.studies.figures.attainment import attainment_figure, difference_figure
from mgeo.studies.figures.comparison import comparison_figures
from mgeo.studies.figures.fronts import each_figure, fronts_figure
from mgeo.studies.figures.indicators import anytime_figure, boxes_figure
from mgeo.studies.figures.ranks import ranks_figure, targets_figure

__all__ = [
    "anytime_figure",
    "attainment_figure",
    "boxes_figure",
    "comparison_figures",
    "difference_figure",
    "each_figure",
    "fronts_figure",
    "ranks_figure",
    "targets_figure",
]
