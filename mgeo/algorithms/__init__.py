"""Algorithms of the generalized extremal optimization family.

`real` and `binary` are the published variants, of `walkers`; `directed` and `staged` are ours;
`base` makes pymoo algorithms of them; `state` captures and restores runs.
"""

from mgeo.algorithms.binary import MGEOCanonical, MGEOVar
from mgeo.algorithms.directed import MGEODirected
from mgeo.algorithms.real import MGEOReal, MGEOReal2
from mgeo.algorithms.staged import MGEOStaged

__all__ = ["MGEOCanonical", "MGEODirected", "MGEOReal", "MGEOReal2", "MGEOStaged", "MGEOVar"]
