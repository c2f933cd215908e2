"""Algorithms of the generalized extremal optimization family.

Published algorithms are in `real` and `binary`, new ones in `directed` and `staged`. `base` and
`walkers` contain their base classes, `archive` the Pareto archive, and `state` saves and restores
runs. The names exported here, other than MGEO..., are the building blocks of new algorithms.
"""

from mgeo.algorithms.base import ExtremalOptimization
from mgeo.algorithms.binary import BitStrings, MGEOCanonical, MGEOVar
from mgeo.algorithms.directed import MGEODirected
from mgeo.algorithms.encoding import BitEncoding, RealEncoding
from mgeo.algorithms.real import MGEOReal, MGEOReal2
from mgeo.algorithms.run_state import RunState
from mgeo.algorithms.staged import MGEOStaged
from mgeo.algorithms.state import SavedState, capture, restore
from mgeo.algorithms.steps import BOUNDS, StepLaw
from mgeo.algorithms.variables import Variables
from mgeo.algorithms.walkers import IndependentWalkers

__all__ = [
    "BOUNDS",
    "BitEncoding",
    "BitStrings",
    "ExtremalOptimization",
    "IndependentWalkers",
    "MGEOCanonical",
    "MGEODirected",
    "MGEOReal",
    "MGEOReal2",
    "MGEOStaged",
    "MGEOVar",
    "RealEncoding",
    "RunState",
    "SavedState",
    "StepLaw",
    "Variables",
    "capture",
    "restore",
]
