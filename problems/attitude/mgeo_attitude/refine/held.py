"""Rates that are held after what a plan has to learn, until its filter has converged."""

from __future__ import annotations

import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.maneuvers.schedule import VARIABLES_PER_MANEUVER
from mgeo_attitude.refine.at_time import AtTime

#: Rates about each axis, from the greatest backward to the greatest forward.
_LEVELS = 7


def rate_grid(greatest: float, n_levels: int = _LEVELS) -> Floats:
    """Rates [deg/s] on a grid about the three axes, shape (n_levels³, 3)."""
    levels = np.linspace(-greatest, greatest, n_levels)
    return np.stack(np.meshgrid(levels, levels, levels), axis=-1).reshape(-1, 3)


def until_converged(at: AtTime, design: Floats) -> Floats:
    """A design, shape (4 m,), with rates held after it, shape (k, 4 (m + 1)), from k = 1.

    Of the rates of `rate_grid` those by which it converges and knows more than by any by which it
    does so sooner; first those by which it takes about the window of the rule, as what they teach
    then is as little as the rule allows.
    """
    last = rate_grid(at.scenario.maneuvers.max_rate_deg_s)
    before = np.broadcast_to(design, (len(last), len(design)))
    held = np.hstack([before, last, np.zeros((len(last), 1))])
    rows, t_end = at.soonest(held)
    over = design[VARIABLES_PER_MANEUVER - 1 :: VARIABLES_PER_MANEUVER].sum()
    late = np.abs(t_end - over - at.model.step * at.model.window_steps)
    found: Floats = held[rows[np.argsort(late, kind="stable")]]
    return found
