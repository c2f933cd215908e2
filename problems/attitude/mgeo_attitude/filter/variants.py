"""Numerical inputs of the kernel for several variants of a filter model.

A batch may have as many variants as designs, so functions here do little work per variant and rely
on cached properties of the model. `thinned` returns a model for approximate derivatives.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.filter.layout import KernelTraits
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.filter.path_constraints import compute_violation
from mgeo_attitude.filter.symbols import triangle_indices
from mgeo_attitude.maneuvers.actuation import MagnetorquerDrive
from mgeo_attitude.sensors.base import scale_noise
from mgeo_attitude.sensors.gyro import Gyro
from mgeo_attitude.sensors.suite import Suite


def validate_variants(model: FilterModel, variants: Sequence[FilterModel]) -> None:
    """Raise ValueError if a variant needs another kernel than the model, and name the property."""
    for number, variant in enumerate(variants):
        if variant.traits == model.traits:
            continue
        for name, value, expected in zip(
            KernelTraits._fields, variant.traits, model.traits, strict=True
        ):
            if value != expected:
                raise ValueError(
                    f"variants[{number}] differs from the model in {name.replace('_', ' ')}. "
                    "A variant may differ only in noise, field of view, 1-sigmas and weights"
                )


def stack_constants(model: FilterModel, variants: Sequence[FilterModel]) -> Floats:
    """Return the step constants of each variant, shape (n_variants, n_constants).

    The constants are those of `codegen.instrument_constants`, the inverse squares of the monitored
    required 1-sigmas, and the weights of the trace.
    """
    states = list(model.monitors.states)
    required = [[sigma**-2 for sigma in each.required_sigma[states]] for each in variants]
    weights = [each.weights for each in variants]
    return np.hstack([[each.instrument_constants for each in variants], required, weights])


def stack_dynamics(variants: Sequence[FilterModel]) -> tuple[Floats, Floats]:
    """Return `compute_gyro_dynamics` of each variant, stacked along the first axis."""
    gyros = {id(each.suite.gyro): each.suite.gyro for each in variants}  # Few gyros are distinct.
    dynamics = {key: compute_gyro_dynamics(gyro) for key, gyro in gyros.items()}
    matrices, densities = zip(*(dynamics[id(each.suite.gyro)] for each in variants), strict=True)
    return np.array(matrices), np.array(densities)


@lru_cache(maxsize=1000)
def compute_gyro_dynamics(gyro: Gyro) -> tuple[Floats, Floats]:
    """Return the dynamics matrices and the process-noise density of attitude and gyro.

    Gauss-Markov processes of sensors do not depend on the rate and are not included.

    Returns
    -------
    matrices : array, shape (4, n_kinematic, n_kinematic)
        A at zero rate, and the derivative of A by each component of the rate.
    density : array, shape (n_kinematic,)
        Diagonal of the process-noise density.
    """
    alone = Suite(gyro, ())
    rest, *unit = map(alone.dynamics_matrix, np.vstack([np.zeros(3), np.eye(3)]))
    return np.array([rest, *(matrix - rest for matrix in unit)]), alone.compute_noise_density()


def compute_initial_values(model: FilterModel, variants: Sequence[FilterModel]) -> Floats:
    """Return covariance, attitude, monitors and trace at the start, with one row per variant."""
    sigma = np.array([each.initial_sigma for each in variants])
    correlation = np.array([each.initial_correlation for each in variants])
    covariance = sigma[:, :, None] * correlation * sigma[:, None, :]
    variances = np.diagonal(covariance, axis1=1, axis2=2)
    weights = np.array([each.weights for each in variants])
    row, column = triangle_indices(model.suite.n_states)
    watched = bool(model.monitors.states)
    return np.hstack(
        [
            covariance[:, row, column],
            [each.initial_attitude.ravel() for each in variants],
            [_compute_initial_monitors(each, watched) for each in variants],
            np.cumsum(weights * variances, axis=1)[:, -1:],
        ]
    )


def _compute_initial_monitors(model: FilterModel, has_required_sigma: bool) -> list[float]:
    values = []
    still, covariance = np.zeros((1, 3)), model.initial_covariance[None, :3, :3]
    for limit in model.path_constraints:
        cone = limit.build_cone()
        start = model.compute_direction_motion(cone.direction, slice(1)).rotate_to_body(
            model.initial_attitude[None]
        )
        at_start = compute_violation(cone, limit.attitude_sigmas, still, start, covariance)[0]
        values.append(max(-np.pi, at_start))
    if has_required_sigma:
        values.append(float(np.all(model.initial_sigma <= model.required_sigma)))
    return values


def coarsen_model(model: FilterModel, n_merged: int) -> FilterModel:
    """Return a model with a step `n_merged` times as long and equivalent measurement noise.

    The 1-sigmas of a sensor are divided by the root of its mean number of available samples in a
    long step. Steps that remain at the end are dropped. The model itself is returned if it has
    magnetorquer control or a momentum budget, which have tables of their own, or a sensor without
    `noise_parameters`.

    Parameters
    ----------
    model : FilterModel
    n_merged : int
        Number of steps to merge, at least 1.
    """
    coarse = not (
        isinstance(model.slew_limits, MagnetorquerDrive) or model.momentum_budget is not None
    )
    named = all(sensor.noise_parameters for sensor in model.suite.sensors)
    n = model.n_steps // n_merged
    if n_merged == 1 or n < 1 or not (coarse and named):
        return model
    pick = slice(0, n * n_merged + 1, n_merged)
    samples = model.available[1 : n * n_merged + 1].reshape(n, n_merged, -1)
    has_sample = samples.any(axis=1)
    counts = samples.sum(axis=(0, 1)) / np.maximum(has_sample.sum(axis=0), 1)
    suite = Suite(
        model.suite.gyro,
        tuple(
            # One reading stands for the mean of the available samples of a long step.
            dataclasses.replace(
                scale_noise(sensor, 1.0 / math.sqrt(max(float(count), 1.0))), sample_interval=None
            )
            for sensor, count in zip(model.suite.sensors, counts, strict=True)
        ),
        model.suite.environment_errors,
    )
    return model.select_samples(
        pick,
        suite=suite,
        step=n_merged * model.step,
        # The first sample is unused; its values preserve which sensors the kernel gates.
        available=np.vstack([~np.array(model.gated, dtype=bool), has_sample]),
        window_steps=max(round(model.window_steps / n_merged), 1),
        use_polynomials=True,
    )
