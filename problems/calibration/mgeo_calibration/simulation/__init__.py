"""Flights by the hundred: the error-state filter on board, what it claims, and calibrations."""
