"""What is believed at the first of some samples, before any of them is read."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from mgeo_attitude._typing import Floats
from mgeo_attitude.geometry.rotation import matrix, rotation_jacobian, rotation_vector
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.sensors.suite import Suite

from mgeo_calibration.telemetry.held import Held

#: 1-sigma of an attitude of which nothing is known [rad], about that of all rotations.
UNKNOWN = 1.0


@dataclass(frozen=True, eq=False)
class Belief:
    """Estimates and the covariance of their errors.

    Attributes
    ----------
    attitude : array, shape (3, 3), optional
        Body to GCRS; without it the attitude is whatever it is taken to be, give or take `UNKNOWN`.
    states : array, shape (n_states,)
        Of gyro and sensors, rotations as vectors of `rotation.rotate`; zero for the attitude.
    sigma : array, shape (n_states,)
        1-sigmas.
    correlation : array, shape (n_states, n_states)
    """

    suite: Suite
    attitude: Floats | None
    states: Floats
    sigma: Floats
    correlation: Floats

    @classmethod
    def initial(cls, suite: Suite) -> Belief:
        """No error, with the initial 1-sigmas of gyro and sensors, and nothing of the attitude."""
        sigma = suite.initial_sigma(UNKNOWN)
        return cls(suite, None, np.zeros_like(sigma), sigma, suite.initial_correlation)

    @classmethod
    def of(cls, scenario: Scenario, held: Held | None = None) -> Belief:
        """Return the result of an earlier calibration, if there is one, or the `initial` belief.

        Parameters
        ----------
        held : Held, optional
            Attitude from which the initial one is off by the pointing error.
        """
        suite, prior = scenario.suite, scenario.prior
        if prior is None:
            initial = cls.initial(suite)
            if held is None:
                return initial
            initial.sigma[:3] = held.error.sigma
            return replace(initial, attitude=held.attitude[0])
        return cls(suite, prior.attitude.T, prior.estimates, prior.sigma, prior.correlation)

    def without_attitude(self) -> Belief:
        """The same of constants, and nothing of the attitude and of errors that vary."""
        unknown = np.r_[:3, self.suite.n_kinematic : self.suite.n_dynamic]
        correlation, sigma, states = self.correlation.copy(), self.sigma.copy(), self.states.copy()
        correlation[unknown], correlation[:, unknown], states[unknown] = 0.0, 0.0, 0.0
        correlation[unknown, unknown] = 1.0
        sigma[unknown] = self.suite.initial_sigma(UNKNOWN)[unknown]
        return replace(self, attitude=None, states=states, sigma=sigma, correlation=correlation)

    def difference(self, attitude: Floats, states: Floats) -> Floats:
        """Of an estimate of the same sample; of rotations the vector of what is between.

        Shape (n_states,); zero for an attitude of which nothing is known.

        Parameters
        ----------
        attitude : array, shape (3, 3)
            Body to GCRS.
        states : array, shape (n_states,)
        """
        off = states - self.states
        off[:3] = 0.0 if self.attitude is None else rotation_vector(self.attitude.T @ attitude)
        for first in self.suite.rotations:
            block = slice(first, first + 3)
            if first and self.states[block].any():
                off[block] = rotation_vector(matrix(self.states[block]).T @ matrix(states[block]))
        return off

    def residual(self, attitude: Floats, states: Floats) -> tuple[Floats, Floats]:
        """Residual of an estimate of the same sample and its derivative, -J.

        Parameters
        ----------
        attitude, states
            As of `difference`.

        Returns
        -------
        r : array, shape (n_states,), standard normal
        J : array, shape (n_states, n_states)
            r - J e remains when errors e are taken out.
        """
        off, turned = self.difference(attitude, states), np.eye(len(states))
        for first in self.suite.rotations:
            block = slice(first, first + 3)
            turned[block, block] = rotation_jacobian(off[block])
        whiten = np.linalg.inv(np.linalg.cholesky(self.correlation)) / self.sigma
        return -whiten @ off, whiten @ turned
