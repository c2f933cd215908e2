"""The motion that a plan asks for, step by step."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.filter.reference import attitudes
from mgeo_attitude.filter.timeline import flown

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Motion:
    """A plan on n steps.

    Attributes
    ----------
    step : float
        [s]
    rates : array, shape (n, 3)
        Body rate in each step [rad/s].
    attitude : array, shape (n + 1, 3, 3)
        GCRS to body.
    """

    step: float
    rates: Floats
    attitude: Floats

    @classmethod
    def of(cls, model: FilterModel, design: ArrayLike, n_steps: int) -> Motion:
        """Of a design, shape (4 m,), from body axes along those of GCRS; see `filter.timeline`."""
        plan = flown(design, n_steps * model.step, model.step, model.agility)
        starts = np.rint(plan.times[:-1] / model.step).astype(np.int64)
        maneuver = np.searchsorted(starts, np.arange(n_steps), side="right") - 1
        attitude = attitudes(plan.rates, starts, n_steps, model.step)
        return cls(model.step, plan.rates[maneuver], attitude)
