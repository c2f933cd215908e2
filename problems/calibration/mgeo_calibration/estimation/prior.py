"""Prior estimate of attitude and calibration parameters at the first sample of a batch."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from mgeo_attitude._typing import Floats
from mgeo_attitude.geometry.rotation import rotation_jacobian, rotation_matrix, rotation_vector
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.sensors.suite import Suite

from mgeo_calibration.telemetry.attitude_hold import AssumedAttitude

#: 1-sigma of an unknown attitude [rad], about the spread of uniformly distributed rotations.
UNKNOWN_ATTITUDE_SIGMA = 1.0


@dataclass(frozen=True, eq=False)
class PriorEstimate:
    """Prior estimate with the covariance of its errors.

    Attributes
    ----------
    suite : Suite
    attitude : array, shape (3, 3), optional
        Rotation matrix from body to GCRS. None for an unknown attitude, with the 1-sigma `UNKNOWN_ATTITUDE_SIGMA`
        about any value.
    states : array, shape (n_states,)
        States of the gyro and the sensors; rotations are rotation vectors. The attitude block is
        zero.
    sigma : array, shape (n_states,)
        1-sigma of each state.
    correlation : array, shape (n_states, n_states)
    """

    suite: Suite
    attitude: Floats | None
    states: Floats
    sigma: Floats
    correlation: Floats

    @classmethod
    def from_suite(cls, suite: Suite) -> PriorEstimate:
        """Return the prior of an uncalibrated suite.

        All states are zero with their initial 1-sigmas, and the attitude is unknown.
        """
        sigma = suite.initial_sigma(UNKNOWN_ATTITUDE_SIGMA)
        return cls(suite, None, np.zeros_like(sigma), sigma, suite.initial_correlation)

    @classmethod
    def from_scenario(
        cls, scenario: Scenario, pointing: AssumedAttitude | None = None
    ) -> PriorEstimate:
        """Return the result of an earlier calibration, or `initial` if the scenario has none.

        Parameters
        ----------
        pointing : Held, optional
            Held attitude, from which the initial attitude differs by the pointing error.
        """
        suite, prior = scenario.suite, scenario.prior
        if prior is None:
            initial = cls.from_suite(suite)
            if pointing is None:
                return initial
            initial.sigma[:3] = pointing.pointing_error.sigma
            return replace(initial, attitude=pointing.attitude[0])
        return cls(suite, prior.attitude.T, prior.estimates, prior.sigma, prior.correlation)

    def reset_varying_states(self) -> PriorEstimate:
        """Return a prior with only the constant states.

        The attitude and the varying states have their initial uncertainty again.
        """
        unknown = np.r_[:3, self.suite.n_kinematic : self.suite.n_dynamic]
        correlation, sigma, states = self.correlation.copy(), self.sigma.copy(), self.states.copy()
        correlation[unknown], correlation[:, unknown], states[unknown] = 0.0, 0.0, 0.0
        correlation[unknown, unknown] = 1.0
        sigma[unknown] = self.suite.initial_sigma(UNKNOWN_ATTITUDE_SIGMA)[unknown]
        return replace(self, attitude=None, states=states, sigma=sigma, correlation=correlation)

    def compute_difference(self, attitude: Floats, states: Floats) -> Floats:
        """Return the difference of an estimate from the prior, shape (n_states,).

        Differences of rotations are rotation vectors. The attitude difference is zero if the
        attitude of the prior is unknown.

        Parameters
        ----------
        attitude : array, shape (3, 3)
            Rotation matrix from body to GCRS at the first sample.
        states : array, shape (n_states,)
            Estimated states at the first sample.
        """
        off = states - self.states
        off[:3] = 0.0 if self.attitude is None else rotation_vector(self.attitude.T @ attitude)
        for first in self.suite.rotation_indices:
            block = slice(first, first + 3)
            if first and self.states[block].any():
                off[block] = rotation_vector(
                    rotation_matrix(self.states[block]).T @ rotation_matrix(states[block])
                )
        return off

    def compute_residual(self, attitude: Floats, states: Floats) -> tuple[Floats, Floats]:
        """Return the whitened residual of the prior and its Jacobian.

        Parameters
        ----------
        attitude : array, shape (3, 3)
            Rotation matrix from body to GCRS at the first sample.
        states : array, shape (n_states,)
            Estimated states at the first sample.

        Returns
        -------
        r : array, shape (n_states,)
            Residual; standard normal if the prior is consistent.
        J : array, shape (n_states, n_states)
            The residual becomes r - J e when the estimate is corrected by the errors e.
        """
        off, turned = self.compute_difference(attitude, states), np.eye(len(states))
        for first in self.suite.rotation_indices:
            block = slice(first, first + 3)
            turned[block, block] = rotation_jacobian(off[block])
        whiten = np.linalg.inv(np.linalg.cholesky(self.correlation)) / self.sigma
        return -whiten @ off, whiten @ turned
