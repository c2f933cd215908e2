"""Pictures of results."""

from mgeo.figures.front import MOST_OBJECTIVES, MOST_TEXTS, front_figure
from mgeo.figures.page import page, report_page

__all__ = ["MOST_OBJECTIVES", "MOST_TEXTS", "front_figure", "page", "report_page"]
