"""What is estimated, with the covariance of its errors; runs are the last axis of all arrays."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.geometry.rotation import matrix, multiply, skew, vector
from mgeo_attitude.sensors.suite import Suite


@dataclass(frozen=True)
class Estimate:
    """Estimates of r runs.

    The error of a rotation is a rotation, R = R̂ R(e); that of any other state a difference.

    Attributes
    ----------
    places : array of int, shape (3, k)
        States that are rotations, attitude first; see `Suite.rotations`.
    rotations : array, shape (3, 3, k, r)
        Body to GCRS, then those of the other states.
    states : array, shape (n_states, r)
        States that are no rotations; zero for those that are.
    covariance : array, shape (n_states, n_states, r)
        Of the errors.
    """

    places: Ints
    rotations: Floats
    states: Floats
    covariance: Floats

    @classmethod
    def of(cls, suite: Suite, attitude: Floats, states: Floats, covariance: Floats) -> Estimate:
        """Of attitudes, body to GCRS, shape (3, 3, r), and states with the vectors of rotations."""
        places = np.arange(3)[:, None] + np.array(suite.rotations)
        rotations, others = matrix(states[places]), states.copy()
        rotations[:, :, 0], others[places] = attitude, 0.0
        return cls(places, rotations, others, covariance)

    @classmethod
    def at_start(cls, model: FilterModel, n_runs: int = 1) -> Estimate:
        """What a model says of the start, the same in all runs."""
        states = np.repeat(model.initial_states[:, None], n_runs, axis=-1)
        P = np.repeat(model.initial_covariance[..., None], n_runs, axis=-1)
        return cls.of(model.suite, model.initial_attitude.T[..., None], states, P)

    def corrected(self, e: Floats, covariance: Floats) -> Estimate:
        """With errors e, shape (n_states, r), taken out, and the covariance of what remains."""
        states = self.states + e
        states[self.places] = 0.0
        rotations = np.einsum("ijkr,jlkr->ilkr", self.rotations, matrix(e[self.places]))
        return Estimate(self.places, rotations, states, covariance)

    def error(self, attitude: Floats, states: Floats) -> Floats:
        """What `corrected` would have to take out to come to the truth, shape (n_states, r).

        Parameters
        ----------
        attitude : array, shape (3, 3, r)
            GCRS to body.
        states : array, shape (n_states, r)
            With the vectors of rotations.
        """
        true = matrix(states[self.places])
        true[:, :, 0] = attitude.swapaxes(0, 1)
        e = states - self.states
        e[self.places] = vector(np.einsum("jikr,jlkr->ilkr", self.rotations, true))
        return e


def reset(P: Floats, e: Floats, places: Ints) -> None:
    """Turn covariances, in place, into those of the errors that remain once e is taken out.

    What remains of an error g of a rotation is the vector of R(-e) R(g), whose derivative at g = e
    is (I - ½ [e×]) / (1 + |e|² / 4).
    """
    g = e[places]
    turns = (np.eye(3)[:, :, None, None] - 0.5 * skew(g)) / (1.0 + 0.25 * (g * g).sum(axis=0))
    for number, first in enumerate(places[0]):
        turn, block = turns[:, :, number], slice(first, first + 3)
        rows = multiply(turn, P[block])
        P[block], P[:, block] = rows, rows.swapaxes(0, 1)
        P[block, block] = multiply(rows[:, block], turn.swapaxes(0, 1))
