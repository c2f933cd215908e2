"""Numerical inputs of the compiled filter for several variants of a model, such as other sensors.

A batch may have as many variants as designs. The functions therefore do little work per variant and
rely on cached properties of the model. `coarsen_model` returns a fast model for approximate
derivatives, which the local refinement uses.
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
from mgeo_attitude.filter.path_constraints import compute_monitored_angle
from mgeo_attitude.filter.symbols import triangle_indices
from mgeo_attitude.maneuvers.actuation import MagnetorquerDrive
from mgeo_attitude.sensors.base import scale_noise
from mgeo_attitude.sensors.gyro import Gyro
from mgeo_attitude.sensors.suite import Suite


def validate_variants(model: FilterModel, variants: Sequence[FilterModel]) -> None:
    """Raise ValueError if a variant cannot use the compiled filter of the model.

    The message names the first property that differs.
    """
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
    """Return an array of the constants that a filter step reads, with one row per model variant.

    The array has shape (n_variants, n_constants). The constants are those of
    `codegen.compute_instrument_constants`, then the inverse squares of the required 1-sigmas, then
    the weights of the trace.
    """
    states = list(model.monitors.states)
    required = [[sigma**-2 for sigma in variant.required_sigma[states]] for variant in variants]
    weights = [variant.weights for variant in variants]
    return np.hstack([[variant.instrument_constants for variant in variants], required, weights])


def stack_dynamics(variants: Sequence[FilterModel]) -> tuple[Floats, Floats]:
    """Stack the dynamics matrices and the process-noise densities of all model variants.

    The dynamics are those of attitude and gyro errors. The first axis of both arrays is the model
    variant.
    """
    gyros = {
        id(variant.suite.gyro): variant.suite.gyro for variant in variants
    }  # Most variants share a gyro.
    dynamics = {key: compute_gyro_dynamics(gyro) for key, gyro in gyros.items()}
    matrices, densities = zip(
        *(dynamics[id(variant.suite.gyro)] for variant in variants), strict=True
    )
    return np.array(matrices), np.array(densities)


@lru_cache(maxsize=1000)
def compute_gyro_dynamics(gyro: Gyro) -> tuple[Floats, Floats]:
    """Return the dynamics matrices and the process-noise density of attitude and gyro errors.

    The Gauss-Markov processes of sensors do not depend on the body rate and are not included.

    Returns
    -------
    matrices : array, shape (4, n_kinematic, n_kinematic)
        Dynamics matrix A at zero rate, and the derivative of A with respect to each component of
        the rate.
    density : array, shape (n_kinematic,)
        Diagonal of the process-noise density.
    """
    suite = Suite(gyro, ())
    base, *unit_rate_matrices = map(suite.dynamics_matrix, np.vstack([np.zeros(3), np.eye(3)]))
    return np.array(
        [base, *(matrix - base for matrix in unit_rate_matrices)]
    ), suite.compute_noise_density()


def compute_initial_values(model: FilterModel, variants: Sequence[FilterModel]) -> Floats:
    """Return the initial filter state of each model variant, with one row per variant.

    A row contains covariance, attitude, monitored values and covariance trace.
    """
    sigma = np.array([variant.initial_sigma for variant in variants])
    correlation = np.array([variant.initial_correlation for variant in variants])
    covariance = sigma[:, :, None] * correlation * sigma[:, None, :]
    variances = np.diagonal(covariance, axis1=1, axis2=2)
    weights = np.array([variant.weights for variant in variants])
    row, column = triangle_indices(model.suite.n_states)
    has_required_sigma = bool(model.monitors.states)
    return np.hstack(
        [
            covariance[:, row, column],
            [variant.initial_attitude.ravel() for variant in variants],
            [_compute_initial_monitors(variant, has_required_sigma) for variant in variants],
            np.cumsum(weights * variances, axis=1)[:, -1:],
        ]
    )


def _compute_initial_monitors(model: FilterModel, has_required_sigma: bool) -> list[float]:
    values = []
    rotation_vectors, covariance = np.zeros((1, 3)), model.initial_covariance[None, :3, :3]
    for constraint in model.path_constraints:
        cone = constraint.build_cone()
        motion = model.compute_direction_motion(cone.direction, slice(1)).rotate_to_body(
            model.initial_attitude[None]
        )
        monitored_angle = compute_monitored_angle(
            cone, constraint.attitude_sigmas, rotation_vectors, motion, covariance
        )[0]
        values.append(max(-np.pi, monitored_angle))
    if has_required_sigma:
        values.append(float(np.all(model.initial_sigma <= model.required_sigma)))
    return values


def coarsen_model(model: FilterModel, n_merged: int) -> FilterModel:
    """Return an approximate model in which every `n_merged` filter steps are merged into one.

    The noise 1-sigmas of a sensor are divided by the square root of its mean number of available
    samples in a long step. Remaining steps at the end are dropped. The model is returned unchanged
    if it has magnetorquer control or a momentum budget, which have separate tables, or a sensor
    without `noise_parameters`.

    Parameters
    ----------
    model : FilterModel
    n_merged : int
        Number of steps to merge, at least 1.
    """
    has_plain_tables = not (
        isinstance(model.slew_limits, MagnetorquerDrive) or model.momentum_budget is not None
    )
    has_noise_parameters = all(sensor.noise_parameters for sensor in model.suite.sensors)
    n_steps = model.n_steps // n_merged
    if n_merged == 1 or n_steps < 1 or not (has_plain_tables and has_noise_parameters):
        return model
    selection = slice(0, n_steps * n_merged + 1, n_merged)
    samples = model.available[1 : n_steps * n_merged + 1].reshape(n_steps, n_merged, -1)
    has_sample = samples.any(axis=1)
    counts = samples.sum(axis=(0, 1)) / np.maximum(has_sample.sum(axis=0), 1)
    suite = Suite(
        model.suite.gyro,
        tuple(
            # One measurement represents the mean of the available samples of a long step.
            dataclasses.replace(
                scale_noise(sensor, 1.0 / math.sqrt(max(float(count), 1.0))), sample_interval=None
            )
            for sensor, count in zip(model.suite.sensors, counts, strict=True)
        ),
        model.suite.environment_errors,
    )
    return model.select_samples(
        selection,
        suite=suite,
        step=n_merged * model.step,
        # The first sample is not used. Its values keep `gated`, and so the kernel, unchanged.
        available=np.vstack([~np.array(model.gated, dtype=bool), has_sample]),
        window_steps=max(round(model.window_steps / n_merged), 1),
        use_polynomials=True,
    )
