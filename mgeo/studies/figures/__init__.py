"""Figures of comparisons: indicators over evaluations, fronts, attainment, and ranks."""
