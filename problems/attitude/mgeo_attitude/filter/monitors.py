"""What is watched of every design along its run, beside the filter itself."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .keep_out import sun_clearance

Floats = NDArray[np.float64]

#: The cosine of the angle to a direction that was never looked at, and minus the angle.
NEVER_SEEN = -2.0
FARTHEST = -np.pi


@dataclass(frozen=True)
class Monitors:
    """Which values a kernel keeps of each design; they lie one after the other.

    Attributes
    ----------
    cones : tuple of bool
        For each body axis that must stay off the Sun, whether it does with a margin for the unknown
        attitude. With one, the greatest excess of the margin over the angle between is kept [rad];
        without, the greatest cosine of the angle.
    states : tuple of int
        States with a required 1-sigma. If there are any, one value follows: at how many samples up
        to now, without a break, all requirements have been met.
    """

    cones: tuple[bool, ...] = ()
    states: tuple[int, ...] = ()

    @property
    def n_cones(self) -> int:
        return len(self.cones)

    @property
    def total(self) -> int:
        return self.n_cones + (1 if self.states else 0)

    def start(
        self, axes: Floats, sigmas: Floats, target: Floats, initial: Floats, required: Floats
    ) -> Floats:
        """Values at time zero, with body axes along GCRS, shape (total,).

        Parameters
        ----------
        axes : array, shape (n_cones, 3)
            Unit vectors, body axes.
        sigmas : array, shape (n_cones,)
            Margin of each, in 1-sigmas of the angle.
        target : array, shape (3,)
            Direction to the Sun, zero where it does not shine.
        initial, required : arrays, shape (n_states,)
            1-sigma at time zero, and required.
        """
        cosines = axes @ target if np.any(target) else np.full(len(axes), NEVER_SEEN)
        covariance = np.diag(initial[:3] ** 2)[None]
        angles = [
            sun_clearance(axis, k, target[None], covariance)[0]
            for axis, k in zip(axes, sigmas, strict=True)
        ]
        excess = np.maximum(FARTHEST, -np.array(angles))
        watched = np.where(self.cones, excess, cosines)
        if not self.states:
            return watched
        return np.append(watched, float(np.all(initial <= required)))
