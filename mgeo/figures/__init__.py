"""Pictures of results."""

from mgeo.figures.front import front_figure
from mgeo.figures.page import page

__all__ = ["front_figure", "page"]
