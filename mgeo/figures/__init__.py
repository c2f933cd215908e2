"""Pictures of results."""

from mgeo.figures.front import front_figure
from mgeo.figures.page import page, report_page

__all__ = ["front_figure", "page", "report_page"]
