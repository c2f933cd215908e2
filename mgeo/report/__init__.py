"""HTML pages for reviews: the report of a run, and the comparison of two runs."""

from mgeo.report.build import build_report_html
from mgeo.report.compare import build_comparison_html

__all__ = [
    "build_comparison_html",
    "build_report_html",
]
