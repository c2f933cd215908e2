"""Pictures of results."""

from mgeo.figures.front import MOST_OBJECTIVES, front_figure
from mgeo.figures.page import page, report_page

__all__ = ["MOST_OBJECTIVES", "front_figure", "page", "report_page"]
