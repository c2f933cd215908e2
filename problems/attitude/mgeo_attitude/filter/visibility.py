"""When a sensor can measure on a way that is flown."""

from __future__ import annotations

import numpy as np

from mgeo_attitude._typing import Bools, Floats
from mgeo_attitude.filter.model import FilterModel


def can_measure(model: FilterModel, index: int, attitude: Floats, rates: Floats) -> Bools:
    """Samples at which a sensor can measure, shape (n_steps + 1,).

    Parameters
    ----------
    attitude : array, shape (n_steps + 1, 3, 3)
        GCRS to body.
    rates : array, shape (n_steps, 3)
        Body rate in each step [rad/s].
    """
    sensor, mask = model.suite.sensors[index], model.available[:, index].copy()
    for view in sensor.views():
        looked_at, radius = model.references[:, index], np.zeros(len(attitude))
        if view.direction:
            looked_at, radius = model.direction(view.direction)
        cosine = np.einsum("kij,kj->ki", attitude, looked_at) @ view.axis
        mask &= (cosine >= np.cos(view.half_angle + radius)) == view.inside
    mask[1:] &= np.einsum("ki,ki->k", rates, rates) <= sensor.max_rate() ** 2
    return mask
