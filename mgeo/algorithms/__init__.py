"""Algorithms of the generalized extremal optimization family.

`real` and `binary` are the published variants, of `walkers`; `directed`, of the candidates that
`moves` makes, and `staged` are ours; `base` makes pymoo algorithms of them; `archive` keeps what is
nondominated; `state` captures and restores runs. What is not called MGEO here is what a variant of
one's own is made of.
"""

from mgeo.algorithms.base import ExtremalOptimization
from mgeo.algorithms.binary import BitStrings, MGEOCanonical, MGEOVar
from mgeo.algorithms.coding import BitCode, RealCode
from mgeo.algorithms.directed import MGEODirected
from mgeo.algorithms.real import MGEOReal, MGEOReal2
from mgeo.algorithms.run_state import RunState
from mgeo.algorithms.staged import MGEOStaged
from mgeo.algorithms.state import SavedState, capture, restore
from mgeo.algorithms.steps import BOUNDS, StepLaw
from mgeo.algorithms.variables import Variables
from mgeo.algorithms.walkers import IndependentWalkers

__all__ = [
    "BOUNDS",
    "BitCode",
    "BitStrings",
    "ExtremalOptimization",
    "IndependentWalkers",
    "MGEOCanonical",
    "MGEODirected",
    "MGEOReal",
    "MGEOReal2",
    "MGEOStaged",
    "MGEOVar",
    "RealCode",
    "RunState",
    "SavedState",
    "StepLaw",
    "Variables",
    "capture",
    "restore",
]
