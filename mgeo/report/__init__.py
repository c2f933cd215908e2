"""HTML reports of runs for reviews: configuration, front and solutions, or two runs compared."""

from mgeo.report.build import report_html
from mgeo.report.compare import compare_html

__all__ = [
    "compare_html",
    "report_html",
]
