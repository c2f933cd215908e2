"""What a generated kernel keeps of each candidate, and where: the slots of its workspace."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from itertools import accumulate
from typing import NamedTuple

import numpy as np

from .suite import Suite


@dataclass(frozen=True)
class Monitors:
    """What is watched of every design along its run, beside the filter itself.

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
    def total(self) -> int:
        return len(self.cones) + bool(self.states)


NO_MONITORS = Monitors()


class Layout(NamedTuple):
    """First slot of each kind of value, in this order.

    The covariance is before all others, from slot 0 on. It, the `attitude` and the `monitors` are a
    candidate's state; `rotation`, `F` and `Q` are those of one step of its maneuver. `trace` and
    `pivot` are what `step` and `check` find. `given` are what the orbit gives at the step; the
    `constants` are the same for all candidates.
    """

    attitude: int
    monitors: int
    rotation: int
    F: int
    Q: int
    trace: int
    pivot: int
    given: int
    constants: int


@cache
def layout(suite: Suite, gated: tuple[bool, ...], monitors: Monitors = NO_MONITORS) -> Layout:
    """Workspace of a suite; `gated` tells which sensors are not available at every sample.

    Given are the reference of each sensor, their gradients, the Sun if cones must stay off it, and
    whether each gated sensor is available: a row of `FilterModel.table`.
    """
    n, m = suite.n_states, suite.n_kinematic
    given = 3 * (suite.n_vectors + bool(monitors.cones)) + sum(gated)
    n_transition = len(transition_pattern(suite))
    sizes = [_half(n), 9, monitors.total, 9, n_transition, _half(m), 1, 1, given]
    return Layout(*accumulate(sizes))


@cache
def transition_pattern(suite: Suite) -> tuple[tuple[int, int], ...]:
    """Entries of exp(A dt), for any rate, in the rows of the kinematic states that change.

    They are the transitive closure of A's pattern. A state without dynamics and without process
    noise is constant: its row stays the identity's and is left out.
    """
    k = suite.n_kinematic
    generic = np.zeros((k, k), dtype=bool)
    for omega in np.vstack([np.zeros(3), np.eye(3)]):
        generic |= suite.dynamics_matrix(omega)[:k, :k] != 0.0
    closure = generic | np.eye(k, dtype=bool)
    for _ in range(k):
        closure = closure @ closure
    rows = generic.any(axis=1) | (suite.diffusion()[:k] > 0.0)
    return tuple((int(i), int(j)) for i, j in np.argwhere(closure) if rows[i])


def _half(n: int) -> int:
    """Entries of a lower triangle."""
    return n * (n + 1) // 2
