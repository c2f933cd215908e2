"""Errors that are neither constant nor white: first-order Gauss-Markov processes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np


@dataclass(frozen=True)
class GaussMarkov:
    """An error e' = -e / τ + white noise, stationary: an Ornstein-Uhlenbeck process.

    In `Sensor.states` it stands where a constant has its initial 1-sigma. Its autocorrelation
    after a time t is exp(-t / τ) (A. Gelb, Applied Optimal Estimation, 1974, section 2.2).

    Attributes
    ----------
    sigma : float
        1-sigma per axis, the same at all times.
    correlation_time : float
        τ [s].
    """

    sigma: float
    correlation_time: float

    @property
    def density(self) -> float:
        """Power spectral density of the noise that drives it, per axis."""
        return 2.0 * self.sigma**2 / self.correlation_time

    def over(self, duration: Any) -> tuple[Any, Any]:
        """Factor by which it decays over a duration [s], and the variance that comes new.

        Of an array of durations arrays.
        """
        ratio = duration / self.correlation_time
        return np.exp(-ratio), -(self.sigma**2) * np.expm1(-2.0 * ratio)


def sigma_of(state: float | GaussMarkov) -> float:
    """Initial 1-sigma of a state."""
    return state.sigma if isinstance(state, GaussMarkov) else state
