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
    """Prior estimate of attitude and states at the first sample of a batch.

    Attributes
    ----------
    suite : Suite
    attitude : array, shape (3, 3), optional
        Rotation matrix from body to GCRS. None for an unknown attitude, which has the 1-sigma
        `UNKNOWN_ATTITUDE_SIGMA`.
    states : array, shape (n_states,)
        States of the gyro and the sensors; rotations are rotation vectors. The attitude block is
        zero.
    sigma : array, shape (n_states,)
        1-sigma of each state.
    correlation : array, shape (n_states, n_states)
        Correlation matrix of the errors.
    """

    suite: Suite
    attitude: Floats | None
    states: Floats
    sigma: Floats
    correlation: Floats

    @classmethod
    def from_suite(cls, suite: Suite) -> PriorEstimate:
        """Return the prior of an uncalibrated suite, with unknown attitude, zero states and initial
        1-sigmas.
        """
        sigma = suite.initial_sigma(UNKNOWN_ATTITUDE_SIGMA)
        return cls(suite, None, np.zeros_like(sigma), sigma, suite.initial_correlation)

    @classmethod
    def from_scenario(
        cls, scenario: Scenario, pointing: AssumedAttitude | None = None
    ) -> PriorEstimate:
        """Return the prior of a scenario. It is the result of an earlier calibration or, without
        one, the prior of the uncalibrated suite.

        Parameters
        ----------
        scenario : Scenario
        pointing : AssumedAttitude, optional
            Attitude that the satellite is assumed to hold. Without an earlier calibration, this is
            the prior attitude, with the 1-sigma of the pointing error.
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
        """Return a copy of the prior with an unknown attitude and initial values of the
        time-varying sensor states.

        All other states are unchanged.
        """
        reset = np.r_[:3, self.suite.n_kinematic : self.suite.n_dynamic]
        correlation, sigma, states = self.correlation.copy(), self.sigma.copy(), self.states.copy()
        correlation[reset], correlation[:, reset], states[reset] = 0.0, 0.0, 0.0
        correlation[reset, reset] = 1.0
        sigma[reset] = self.suite.initial_sigma(UNKNOWN_ATTITUDE_SIGMA)[reset]
        return replace(self, attitude=None, states=states, sigma=sigma, correlation=correlation)

    def compute_difference(self, attitude: Floats, states: Floats) -> Floats:
        """Return an estimate at the first sample minus the prior, as an array of shape (n_states,).

        Differences of rotations are rotation vectors. The attitude difference is zero if the
        attitude of the prior is unknown.

        Parameters
        ----------
        attitude : array, shape (3, 3)
            Rotation matrix from body to GCRS at the first sample.
        states : array, shape (n_states,)
            Estimated states at the first sample.
        """
        difference = states - self.states
        difference[:3] = (
            0.0 if self.attitude is None else rotation_vector(self.attitude.T @ attitude)
        )
        for first in self.suite.rotation_indices:
            block = slice(first, first + 3)
            if first and self.states[block].any():
                difference[block] = rotation_vector(
                    rotation_matrix(self.states[block]).T @ rotation_matrix(states[block])
                )
        return difference

    def compute_residual(self, attitude: Floats, states: Floats) -> tuple[Floats, Floats]:
        """Return the difference between the prior and an estimate, whitened by the prior
        covariance, with its negative Jacobian.

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
            Negative Jacobian: the residual becomes r - J e when the estimate is corrected by the
            errors e.
        """
        difference, derivative = self.compute_difference(attitude, states), np.eye(len(states))
        for first in self.suite.rotation_indices:
            block = slice(first, first + 3)
            derivative[block, block] = rotation_jacobian(difference[block])
        whitening = np.linalg.inv(np.linalg.cholesky(self.correlation)) / self.sigma
        return -whitening @ difference, whitening @ derivative
