"""Plans whose maneuvers end within steps of the filter: values then change smoothly with them."""

from __future__ import annotations

import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.maneuvers.schedule import VARIABLES_PER_MANEUVER

#: By how much of a step ends are early, so that rounding does not put them past a step.
_EARLY = 1e-6


def with_partial_steps(designs: Floats, step: float) -> Floats:
    """Designs, shape (n, 4 m), as ones that end on steps, shape (n, 4 (2 m - 1)).

    In the step [s] in which one maneuver or more end the rate is the mean of theirs, as long as
    each of them is flown in it.
    """
    maneuvers = designs.reshape(len(designs), -1, VARIABLES_PER_MANEUVER)
    rates, ends = maneuvers[:, :, :3], np.cumsum(maneuvers[:, :, 3], axis=1) / step
    if ends.shape[1] == 1:
        return designs
    starts = np.hstack([np.zeros((len(ends), 1)), ends[:, :-1]])
    shared = np.floor(ends[:, :-1])  # the step in which each ends, shape (n, m - 1)
    flown = np.minimum(shared[:, :, None] + 1.0, ends[:, None]) - np.maximum(
        shared[:, :, None], starts[:, None]
    )
    flown = np.maximum(flown, 0.0)
    flown[:, :, -1] += 1.0 - flown.sum(axis=2)  # the last rate is held
    n, m = ends.shape
    found = np.empty((n, 2 * m - 1, VARIABLES_PER_MANEUVER))
    found[:, ::2, :3], found[:, 1::2, :3] = rates, flown @ rates
    until = np.empty((n, 2 * m - 1))
    until[:, :-1:2], until[:, 1::2] = shared, shared + 1.0
    until[:, -1] = np.ceil(ends[:, -1] - _EARLY)
    until = np.maximum.accumulate(until, axis=1)
    found[:, :, 3] = step * np.diff(np.maximum(until - _EARLY, 0.0), axis=1, prepend=0.0)
    return found.reshape(n, -1)
