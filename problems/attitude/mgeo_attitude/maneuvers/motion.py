"""Rates and attitudes of a design, step by step."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from mgeo_attitude._typing import Floats
from mgeo_attitude.maneuvers.attitude import attitudes
from mgeo_attitude.maneuvers.schedule import flown
from mgeo_attitude.maneuvers.slew import SlewLimits


class Body(Protocol):
    """What is turned; a `FilterModel` tells it."""

    @property
    def step(self) -> float:
        """Step of the filter [s]."""

    @property
    def slew_limits(self) -> SlewLimits | None:
        """How fast rates can change, if not at once."""

    @property
    def initial_attitude(self) -> Floats:
        """GCRS to body at the start, shape (3, 3)."""


@dataclass(frozen=True)
class Motion:
    """A plan on n steps, from the attitude at the start that is believed.

    Attributes
    ----------
    rates : array, shape (n, 3)
        Body rate in each step [rad/s].
    attitude : array, shape (n + 1, 3, 3)
        GCRS to body.
    """

    rates: Floats
    attitude: Floats

    @classmethod
    def of(cls, body: Body, design: ArrayLike, n_steps: int) -> Motion:
        """Of a design, shape (4 m,), and what flies it."""
        plan = flown(design, n_steps * body.step, body.step, body.slew_limits)
        starts = np.rint(plan.times[:-1] / body.step).astype(np.int64)
        stretch = np.searchsorted(starts, np.arange(n_steps), side="right") - 1
        initial = body.initial_attitude
        flown_attitudes = attitudes(plan.rates, starts, n_steps, body.step, initial)
        return cls(plan.rates[stretch], flown_attitudes)
