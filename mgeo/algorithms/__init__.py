"""Algorithms of the generalized extremal optimization family."""

from mgeo.algorithms.real import MGEOReal

__all__ = ["MGEOReal"]
