"""Rates that are held after what a plan has to learn, until its filter has converged."""

from __future__ import annotations

import numpy as np

from mgeo_attitude._typing import Floats

#: Rates about each axis, from the greatest backward to the greatest forward.
_LEVELS = 7


def rate_grid(greatest: float) -> Floats:
    """Rates [deg/s] on a grid about the three axes, shape (343, 3)."""
    levels = np.linspace(-greatest, greatest, _LEVELS)
    return np.stack(np.meshgrid(levels, levels, levels), axis=-1).reshape(-1, 3)


def held_rates(design: Floats, greatest: float, rates: Floats | None = None) -> Floats:
    """A design, shape (4 m,), with each of the rates held after it, shape (n, 4 (m + 1)).

    Without `rates` they are those of `rate_grid`.
    """
    last = rate_grid(greatest) if rates is None else rates
    before = np.broadcast_to(design, (len(last), len(design)))
    return np.hstack([before, last, np.zeros((len(last), 1))])
