"""HTML reports of runs for reviews: configuration, front and solutions, or two runs compared."""

from mgeo.report.build import build_report_html
from mgeo.report.compare import build_comparison_html

__all__ = [
    "build_comparison_html",
    "build_report_html",
]
