"""Where the generated kernel keeps its values: the numbers of the workspace's slots."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .monitors import Monitors
from .suite import Suite

NO_MONITORS = Monitors()


@dataclass(frozen=True)
class Layout:
    """Numbers of the workspace's values: the first value of each kind, then the total.

    What the orbit gives at a step, references and gates, lies in a row of a table of its own.
    """

    n_states: int
    #: Entries of the transition matrix that can differ from the identity's, by (row, column).
    transition: tuple[tuple[int, int], ...]
    n_dynamic: int
    n_references: int
    n_gates: int
    n_monitors: int

    @property
    def attitude(self) -> int:
        return self.n_states * (self.n_states + 1) // 2

    @property
    def monitors(self) -> int:
        return self.attitude + 9

    @property
    def rotation(self) -> int:
        return self.monitors + self.n_monitors

    @property
    def F(self) -> int:
        return self.rotation + 9

    @property
    def Q(self) -> int:
        return self.F + len(self.transition)

    @property
    def trace(self) -> int:
        return self.Q + self.n_dynamic * (self.n_dynamic + 1) // 2

    @property
    def pivot(self) -> int:
        return self.trace + 1

    @property
    def total(self) -> int:
        return self.pivot + 1

    @property
    def gate(self) -> int:
        """First gate in a row of references and gates."""
        return 3 * self.n_references

    @property
    def row(self) -> int:
        return self.gate + self.n_gates


def layout(suite: Suite, gated: tuple[bool, ...], monitors: Monitors = NO_MONITORS) -> Layout:
    """Workspace of a suite; `gated` tells which sensors are not available at every sample.

    The Sun is one more reference, after those of the sensors, if cones must stay off it.
    """
    return Layout(
        n_states=suite.n_states,
        transition=transition_pattern(suite),
        n_dynamic=suite.n_dynamic,
        n_references=len(suite.sensors) + (monitors.n_cones > 0),
        n_gates=sum(gated),
        n_monitors=monitors.total,
    )


def transition_pattern(suite: Suite) -> tuple[tuple[int, int], ...]:
    """Entries of exp(A dt), for any rate, in the rows of the states that change.

    They are the transitive closure of A's pattern. A state without dynamics and without process
    noise is constant: its row stays the identity's and is left out.
    """
    generic = np.zeros((suite.n_dynamic, suite.n_dynamic), dtype=bool)
    for omega in np.vstack([np.zeros(3), np.eye(3)]):
        generic |= suite.dynamics_matrix(omega) != 0.0
    closure = generic | np.eye(suite.n_dynamic, dtype=bool)
    for _ in range(suite.n_dynamic):
        closure = closure @ closure
    rows = generic.any(axis=1) | (suite.diffusion() > 0.0)
    return tuple((int(i), int(j)) for i, j in np.argwhere(closure) if rows[i])
