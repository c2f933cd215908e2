"""Maneuvers of a plan: body rates over time, ramps between rates, and phases for display.

This package does not depend on the filter; `filter` runs along a `Schedule`.
"""
