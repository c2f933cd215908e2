"""A run as one HTML file to attach to a review: what was run, the front, and each of its plans."""

from mgeo.report.build import report_html
from mgeo.report.compare import compare_html

__all__ = [
    "compare_html",
    "report_html",
]
