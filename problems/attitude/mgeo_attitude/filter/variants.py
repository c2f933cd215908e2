"""Variants of a filter model as one kernel takes them: their numbers, side by side.

A batch may have as many variants as designs, so what is done here for each is little: most is
taken from what a model keeps of itself.

A `thinned` model is one for slopes that need not be exact.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.filter.layout import Traits
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.filter.path_limits import excess
from mgeo_attitude.filter.symbols import triangle
from mgeo_attitude.maneuvers.drives import CoilDrive
from mgeo_attitude.sensors.base import with_noise
from mgeo_attitude.sensors.gyro import Gyro
from mgeo_attitude.sensors.suite import Suite


def check_variants(model: FilterModel, variants: Sequence[FilterModel]) -> None:
    """ValueError if the compiled kernel of the model does not fit a variant, and which trait."""
    for number, variant in enumerate(variants):
        if variant.traits == model.traits:
            continue
        for name, found, expected in zip(Traits._fields, variant.traits, model.traits, strict=True):
            if found != expected:
                raise ValueError(
                    f"variants[{number}] differs from the model in {name.replace('_', ' ')}: "
                    "expected another value of noise, field of view, 1-sigma or weight only"
                )


def constants_of(model: FilterModel, variants: Sequence[FilterModel]) -> Floats:
    """Constants of a filter step of each variant, shape (n_variants, n_constants).

    Those of `codegen.instrument_constants`; those of the required 1-sigmas that are monitored; then
    the weights of the trace.
    """
    states = list(model.monitors.states)
    required = [[sigma**-2 for sigma in each.required_sigma[states]] for each in variants]
    weights = [each.weights for each in variants]
    return np.hstack([[each.instrument_constants for each in variants], required, weights])


def dynamics_of(variants: Sequence[FilterModel]) -> tuple[Floats, Floats]:
    """`gyro_dynamics` of each variant, side by side."""
    gyros = {id(each.suite.gyro): each.suite.gyro for each in variants}  # many have few
    known = {key: gyro_dynamics(gyro) for key, gyro in gyros.items()}
    matrices, densities = zip(*(known[id(each.suite.gyro)] for each in variants), strict=True)
    return np.array(matrices), np.array(densities)


@lru_cache(maxsize=1000)
def gyro_dynamics(gyro: Gyro) -> tuple[Floats, Floats]:
    """A of attitude and gyro at rest and what a unit rate about each axis adds; noise density.

    Shapes (4, n_kinematic, n_kinematic) and (n_kinematic,). The processes of sensors do not depend
    on the rate.
    """
    alone = Suite(gyro, ())
    rest, *unit = map(alone.dynamics_matrix, np.vstack([np.zeros(3), np.eye(3)]))
    return np.array([rest, *(matrix - rest for matrix in unit)]), alone.diffusion()


def initial_values(model: FilterModel, variants: Sequence[FilterModel]) -> Floats:
    """Covariance, attitude, monitors and trace of each variant at time zero, in a row each."""
    sigma = np.array([each.initial_sigma for each in variants])
    correlation = np.array([each.initial_correlation for each in variants])
    covariance = sigma[:, :, None] * correlation * sigma[:, None, :]
    variances = np.diagonal(covariance, axis1=1, axis2=2)
    weights = np.array([each.weights for each in variants])
    row, column = triangle(model.suite.n_states)
    watched = bool(model.monitors.states)
    return np.hstack(
        [
            covariance[:, row, column],
            [each.initial_attitude.ravel() for each in variants],
            [_monitors_at_start(each, watched) for each in variants],
            np.cumsum(weights * variances, axis=1)[:, -1:],
        ]
    )


def _monitors_at_start(model: FilterModel, watched: bool) -> list[float]:
    """What `layout.Monitors` says, at time zero; with the states', if they are `watched`."""
    values = []
    still, covariance = np.zeros((1, 3)), model.initial_covariance[None, :3, :3]
    for limit in model.path_limits:
        cone = limit.cone()
        start = model.passage(cone.direction, slice(1)).seen(model.initial_attitude[None])
        at_start = excess(cone, limit.attitude_sigmas, still, start, covariance)[0]
        values.append(max(-np.pi, at_start))
    if watched:
        values.append(float(np.all(model.initial_sigma <= model.required_sigma)))
    return values


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
        by_polynomials=True,
    )
