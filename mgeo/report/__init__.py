"""A run as one HTML file to attach to a review: what was run, the front, and each of its plans."""

from mgeo.report.build import report_html

__all__ = ["report_html"]
