"""Algorithms of the generalized extremal optimization family."""

from mgeo.algorithms.canonical import MGEOCanonical
from mgeo.algorithms.directed import MGEODirected
from mgeo.algorithms.real import MGEOReal
from mgeo.algorithms.real2 import MGEOReal2
from mgeo.algorithms.var import MGEOVar

__all__ = ["MGEOCanonical", "MGEODirected", "MGEOReal", "MGEOReal2", "MGEOVar"]
