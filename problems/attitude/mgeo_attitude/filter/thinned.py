"""A filter that takes one sample in the place of several, for slopes that need not be exact."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.maneuvers.coils import CoilDrive
from mgeo_attitude.sensors.base import with_noise
from mgeo_attitude.sensors.suite import Suite


def thinned(model: FilterModel, every: int) -> FilterModel:
    """A model whose step is that of so many, with as much less noise: 1-sigma over their root.

    Of samples of which some are not available a sensor has those that are, in the mean over all
    steps in which there are any. What is left over at the end is left out. Coils and a budget of
    wheels have tables of their own, and a sensor that names no `noise_parameters` cannot be changed
    from outside: of such a model it is the model itself.

    Parameters
    ----------
    every : int
        From 1.
    """
    coarse = not (isinstance(model.slew_limits, CoilDrive) or model.budget is not None)
    named = all(sensor.noise_parameters for sensor in model.suite.sensors)
    n = model.n_steps // every
    if every == 1 or n < 1 or not (coarse and named):
        return model
    pick = slice(0, n * every + 1, every)
    samples = model.available[1 : n * every + 1].reshape(n, every, -1)
    some = samples.any(axis=1)
    counts = samples.sum(axis=(0, 1)) / np.maximum(some.sum(axis=0), 1)
    suite = Suite(
        model.suite.gyro,
        tuple(
            # noise of the mean of so many samples, whenever it has them
            dataclasses.replace(
                with_noise(sensor, 1.0 / math.sqrt(max(float(count), 1.0))), sample_interval=None
            )
            for sensor, count in zip(model.suite.sensors, counts, strict=True)
        ),
        model.suite.world,
    )
    return model.at_samples(
        pick,
        suite=suite,
        step=every * model.step,
        # the sample at the start is not used, and the kernel that gates sensors stays the same
        available=np.vstack([~np.array(model.gated, dtype=bool), some]),
        window_steps=max(round(model.window_steps / every), 1),
    )
