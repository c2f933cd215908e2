"""What is watched of every design along its run, beside the filter itself."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

#: The cosine of the angle to a direction that was never looked at.
NEVER_SEEN = -2.0


@dataclass(frozen=True)
class Monitors:
    """Which values a kernel keeps of each design; they lie one after the other.

    Attributes
    ----------
    n_cones : int
        For each body axis that must stay off the Sun, the greatest cosine of the angle between.
    states : tuple of int
        States with a required 1-sigma. If there are any, one value follows: at how many samples up
        to now, without a break, all requirements have been met.
    """

    n_cones: int = 0
    states: tuple[int, ...] = ()

    @property
    def total(self) -> int:
        return self.n_cones + (1 if self.states else 0)

    def start(self, axes: Floats, target: Floats, initial: Floats, required: Floats) -> Floats:
        """Values at time zero, with body axes along GCRS, shape (total,).

        Parameters
        ----------
        axes : array, shape (n_cones, 3)
            Unit vectors, body axes.
        target : array, shape (3,)
            Direction to the Sun, zero where it does not shine.
        initial, required : arrays, shape (n_states,)
            1-sigma at time zero, and required.
        """
        cosines = axes @ target if np.any(target) else np.full(len(axes), NEVER_SEEN)
        if not self.states:
            return cosines
        return np.append(cosines, float(np.all(initial <= required)))
