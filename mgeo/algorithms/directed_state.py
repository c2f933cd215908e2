"""What walkers with directions carry from one generation to the next."""

from dataclasses import dataclass

from mgeo._typing import FloatArray
from mgeo.algorithms.run_state import RunState


@dataclass(kw_only=True, eq=False, slots=True)
class DirectedState(RunState):
    """The state of a run of `MGEODirected`.

    Attributes
    ----------
    directions : (n_walkers, n_obj) weights of the walkers' objectives.
    memory : (n_walkers, n_var) the best point of each walker since it began.
    memory_F, memory_violation : its objectives, (n_walkers, n_obj), and constraint violation,
        (n_walkers,), infinite while there is none.
    marked_F : (n_walkers, n_obj) objectives of the best point at its last progress, likewise;
        `idle` counts the generations since then.
    """

    directions: FloatArray
    memory: FloatArray
    memory_F: FloatArray
    memory_violation: FloatArray
    marked_F: FloatArray
