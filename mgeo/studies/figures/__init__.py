"""Figures of a comparison: indicators over evaluations and runs, fronts, attainment, ranks."""
