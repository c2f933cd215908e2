"""Algorithms of the generalized extremal optimization family.

`real` and `binary` are the published variants, of `walkers`; `directed` is ours; `base` makes
pymoo algorithms of them; `state` captures and restores runs.
"""

from mgeo.algorithms.binary import MGEOCanonical, MGEOVar
from mgeo.algorithms.directed import MGEODirected
from mgeo.algorithms.real import MGEOReal, MGEOReal2

__all__ = ["MGEOCanonical", "MGEODirected", "MGEOReal", "MGEOReal2", "MGEOVar"]
