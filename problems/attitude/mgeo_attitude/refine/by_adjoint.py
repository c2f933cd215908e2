"""What plans are worth and its slopes, by the adjoint of the filter: a few runs for all of them."""

from __future__ import annotations

import numpy as np

from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.filter import has_slopes, slopes
from mgeo_attitude.maneuvers.schedule import VARIABLES_PER_MANEUVER
from mgeo_attitude.refine.at_time import AtTime, shared_steps, with_partial_steps


def has_adjoint(at: AtTime, steps: Ints) -> bool:
    """Whether `by_adjoint` has the slopes of these values: of the trace, without limits."""
    free = not (at.limits or at.requirements)
    return at.name == "trace" and free and has_slopes(at.model, int(steps.max(initial=0)))


def by_adjoint(at: AtTime, designs: Floats, steps: Ints) -> tuple[Floats, Floats]:
    """Values after so many steps, as `AtTime.values` within steps, and slopes, shape (n, m, 4).

    By rates [deg/s] and durations [s]. Where a maneuver ends on a step, and where it is none, the
    slope by its end is one-sided.
    """
    plan = at.model.schedule(with_partial_steps(designs, at.model.step))
    trace, by_rates = slopes(at.model, plan, steps, at.threads)
    by_rates = np.radians(by_rates) / trace[:, None, None]
    maneuvers = designs.reshape(len(designs), -1, VARIABLES_PER_MANEUVER)
    found = np.zeros(maneuvers.shape)
    found[:, :, :3] = by_rates[:, ::2]
    if maneuvers.shape[1] > 1:
        rates, ends = maneuvers[:, :, :3], np.cumsum(maneuvers[:, :, 3], axis=1) / at.model.step
        shared, flown = shared_steps(ends)
        in_steps = by_rates[:, 1::2]
        found[:, :, :3] += flown.transpose(0, 2, 1) @ in_steps
        # in the step in which it ends, a later end is more of its rate and less of the next one's
        inside = shared[:, :, None] == shared[:, None]
        along = (inside @ in_steps) * (rates[:, :-1] - rates[:, 1:])
        by_ends = along.sum(axis=2) / at.model.step
        found[:, :-1, 3] = np.cumsum(by_ends[:, ::-1], axis=1)[:, ::-1]
    with np.errstate(invalid="ignore"):
        return np.log(trace), found
