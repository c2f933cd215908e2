"""Figures of fronts, and HTML pages that show figures."""
