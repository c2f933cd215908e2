"""Where the Earth's shadow truly is of an orbit that is not quite the one believed."""

from __future__ import annotations

import dataclasses

from mgeo_attitude._typing import Floats
from mgeo_attitude.environment import Environment
from mgeo_attitude.filter.model import FilterModel, availability, sampled


def in_true_shadow(model: FilterModel, environment: Environment, varying: Floats) -> FilterModel:
    """A model whose sensors see the Sun where it truly shines, whoever believes what.

    Parameters
    ----------
    environment : Environment
        Of the orbit that is believed; without its shadow, nothing changes.
    varying : array, shape (n + 1, n_dynamic - 3)
        See `Flight.gyro`.
    """
    suite = model.suite
    if not suite.world.has_orbit_error or not environment.shadow:
        return model
    first = 3 * suite.blocks.index("world.orbit_error") - 3
    there = availability(suite, suite.world.displaced(environment, varying[:, first : first + 3]))
    for column, sensor in zip(there.T, suite.sensors, strict=True):
        column &= sampled(sensor, model.step, len(there))
    return dataclasses.replace(model, available=there)
