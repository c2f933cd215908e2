"""Figures of fronts, and HTML pages of figures."""
