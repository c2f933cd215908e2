"""Rates and attitudes of a design, step by step, along stretches of constant body rate."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.maneuvers.schedule import Turning, flown


def attitudes(
    rates: Floats, starts: Ints, n_steps: int, step: float, initial: Floats | None = None
) -> Floats:
    """Attitude at every sample of one design: GCRS to body, shape (n_steps + 1, 3, 3).

    Parameters
    ----------
    rates : array, shape (m, 3)
        Body rates of the maneuvers [rad/s].
    starts : array, shape (m,)
        Their first steps.
    initial : array, shape (3, 3), optional
        Attitude at the start; default: body axes along those of GCRS.
    """
    C = np.empty((n_steps + 1, 3, 3))
    C[0] = np.eye(3) if initial is None else initial
    ends = np.minimum(np.append(starts[1:], n_steps), n_steps)
    # ramps, and coils, have a stretch in each step, which are turns to be made at once
    alone = Rotation.from_rotvec(-step * rates).as_matrix() if len(rates) else np.empty((0, 3, 3))
    for omega, turn, first, last in zip(rates, alone, starts.tolist(), ends.tolist(), strict=True):
        if last == first + 1:
            C[last] = turn @ C[first]
        elif last > first:
            steps = np.arange(first, last + 1)
            turns = Rotation.from_rotvec(-np.outer((steps - first) * step, omega))
            C[steps] = turns.as_matrix() @ C[first]
    return C


class Body(Protocol):
    """What is turned; a `FilterModel` tells it."""

    @property
    def step(self) -> float:
        """Step of the filter [s]."""

    @property
    def slew_limits(self) -> Turning:
        """What turns it from one rate to the next, if not at once."""

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
