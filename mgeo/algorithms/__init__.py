"""Algorithms of the generalized extremal optimization family.

`real` and `binary` are the published variants, of `walkers`; `directed`, of the candidates that
`moves` makes, and `staged` are ours; `base` makes pymoo algorithms of them; `archive` keeps what is
nondominated; `state` captures and restores runs. What is not called MGEO here is what a variant of
one's own is made of.
"""

from mgeo.algorithms import selection
from mgeo.algorithms.archive import truncate
from mgeo.algorithms.base import ExtremalOptimization
from mgeo.algorithms.binary import BitStrings, MGEOCanonical, MGEOVar
from mgeo.algorithms.coding import BitCode, RealCode
from mgeo.algorithms.directed import MGEODirected
from mgeo.algorithms.matrix_adaptation import Normals
from mgeo.algorithms.moves import Attraction, joint_steps, momentum_steps
from mgeo.algorithms.real import MGEOReal, MGEOReal2
from mgeo.algorithms.recombination import Credit, recombine
from mgeo.algorithms.run_state import RunState
from mgeo.algorithms.selection import (
    distance,
    nearest,
    nearest_drawn,
    pick,
    random_weights,
    rank,
    weight_vectors,
)
from mgeo.algorithms.staged import MGEOStaged
from mgeo.algorithms.state import SavedState, capture, full_name, restore
from mgeo.algorithms.steps import (
    BOUNDS,
    SCALES,
    NormalLaw,
    StepLaw,
    clip,
    perturb,
    reflect,
    resample,
    whole_steps,
)
from mgeo.algorithms.variables import KINDS, MOST_REAL, Variables, designs_of
from mgeo.algorithms.walkers import IndependentWalkers

__all__ = [
    "BOUNDS",
    "KINDS",
    "MOST_REAL",
    "SCALES",
    "Attraction",
    "BitCode",
    "BitStrings",
    "Credit",
    "ExtremalOptimization",
    "IndependentWalkers",
    "MGEOCanonical",
    "MGEODirected",
    "MGEOReal",
    "MGEOReal2",
    "MGEOStaged",
    "MGEOVar",
    "NormalLaw",
    "Normals",
    "RealCode",
    "RunState",
    "SavedState",
    "StepLaw",
    "Variables",
    "capture",
    "clip",
    "designs_of",
    "distance",
    "full_name",
    "joint_steps",
    "momentum_steps",
    "nearest",
    "nearest_drawn",
    "perturb",
    "pick",
    "random_weights",
    "rank",
    "recombine",
    "reflect",
    "resample",
    "restore",
    "selection",
    "truncate",
    "weight_vectors",
    "whole_steps",
]
