"""Error budget of a plan: contribution of each error source to the variances at the end.

The estimation error is linear in its independent sources: initial errors, process noise of gyro and
sensor errors, measurement noise. The covariance at the end is therefore the sum of the covariances
that the sources cause separately *with the gains of the complete filter* (Gelb, Applied Optimal
Estimation, 1974, section 7.4, "error budget"). Variances add up, and 1-sigmas do not. Without a
source the filter would use other gains, so that removing a source reduces the variance by at least
its contribution.

The budget of all states is computed in one pass, in which the transposed error transition is
propagated backward from the end.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.filter.history import build_measurement_model
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.maneuvers.motion import Motion
from mgeo_attitude.sensors.base import Sensor
from mgeo_attitude.sensors.suite import Suite, list_block_units


class ErrorBudget(NamedTuple):
    """Contribution of each error source to the variance of each state at the end of a run.

    Attributes
    ----------
    sources : tuple of str
        ``initial gyro bias``, ``gyro noise``, ``gyro bias drift``, ``Sun sensor noise``...
    variances : array, shape (s, n_states)
        Contributions in squared filter units. The sum over the sources is the diagonal of the
        covariance.
    """

    sources: tuple[str, ...]
    variances: Floats


GYRO_NOISE = "gyro noise"


def format_initial_error(label: str) -> str:
    """Return the name of the initial error of a state, such as "initial gyro bias"."""
    return f"initial {label}"


def format_drift(label: str) -> str:
    """Return the name of the process noise of a state, such as "gyro bias drift"."""
    return f"{label} drift"


def format_sensor_noise(sensor: Sensor) -> str:
    """Return the name of the measurement noise of a sensor, such as "Sun sensor noise".

    A sensor with the default name of its class is called by its kind, as in "Sun sensor noise".
    """
    is_default = sensor.name == getattr(type(sensor), "name", None)
    kind = " ".join(sensor.kind.split("-")[-2:]).replace("sun", "Sun")
    return f"{kind if is_default else sensor.name} noise"


class _Update(NamedTuple):
    sensor: int
    gain: Floats
    error_transition: Floats
    noise: Floats


class _Step(NamedTuple):
    transition: Floats
    process_noise: Floats
    updates: list[_Update]


def compute_error_budget(model: FilterModel, design: ArrayLike, t_end: float) -> ErrorBudget:
    """Compute the contribution of each error source to the variance of each state at `t_end`.

    The gains of the run are those of the complete filter. The computation takes about 0.1 ms per
    filter step.

    Parameters
    ----------
    model : FilterModel
    design : array_like, shape (4 m,)
        Rates [deg/s] and duration [s] of each maneuver in turn.
    t_end : float
        End of the run [s].
    """
    suite, start = model.suite, model.initial_covariance
    driven_blocks = [block for block, density in _iterate_densities(suite) if density.any()]
    labels = {b: unit.label for b, unit in zip(suite.blocks, list_block_units(suite), strict=True)}
    n = suite.n_states
    adjoint, noise_variances = np.eye(n), np.zeros((len(suite.sensors), n))
    drift_variances = np.zeros((len(driven_blocks), n))
    for step in reversed(list(_iterate_steps(model, design, round(t_end / model.step)))):
        for update in reversed(step.updates):
            noise_variances[update.sensor] += (adjoint @ update.gain) ** 2 @ update.noise
            adjoint = adjoint @ update.error_transition
        drift_variances += np.einsum(
            "ij,sjk,ik->si", adjoint, step.process_noise, adjoint, optimize=True
        )
        adjoint = adjoint @ step.transition
    initial = [format_initial_error(labels[b]) for b in suite.blocks]
    if (model.initial_correlation == np.eye(n)).all():
        initial_variances = (adjoint**2 * model.initial_sigma**2).reshape(n, -1, 3).sum(axis=2).T
    else:  # Correlated initial errors cannot be separated.
        initial = ["initial errors, correlated"]
        initial_variances = np.einsum("ij,jk,ik->i", adjoint, start, adjoint)[None]
    drifts = [GYRO_NOISE if b == "attitude" else format_drift(labels[b]) for b in driven_blocks]
    noises = [format_sensor_noise(sensor) for sensor in suite.sensors]
    return ErrorBudget(
        (*initial, *drifts, *noises),
        np.vstack([initial_variances, drift_variances, noise_variances]),
    )


def _iterate_densities(suite: Suite) -> Iterator[tuple[str, Floats]]:
    """Yield the name and the process-noise density of each block of three dynamic states.

    The density has shape (n_dynamic,) and is zero for all other blocks.
    """
    density = suite.compute_noise_density()
    for i in range(0, len(density), 3):
        block_density = np.zeros_like(density)
        block_density[i : i + 3] = density[i : i + 3]
        yield suite.blocks[i // 3], block_density


def _iterate_steps(model: FilterModel, design: ArrayLike, n_steps: int) -> Iterator[_Step]:
    motion = Motion.from_design(model, design, model.n_steps)
    H, R, is_measured = build_measurement_model(model, motion.attitude, motion.rates)
    counts = np.cumsum([0, *(len(sensor.noise_sigmas()) for sensor in model.suite.sensors)])
    rows = [slice(*edges) for edges in pairwise(counts)]
    P, considered = model.initial_covariance, model.suite.considered_indices
    deviations = model.sensitivity_factors[
        :, model.suite.find_sensitivity_columns(model.suite.gyro)
    ]
    current_rate, F, Q, F_at_unit_deviation = (
        np.full(3, np.nan),
        np.empty(0),
        np.empty(0),
        np.empty(0),
    )
    for k, rate in enumerate(motion.rates[:n_steps], 1):
        if (rate != current_rate).any():
            current_rate, (F_at_unit_deviation, Q) = rate, _discretize(model, rate)
            F = F_at_unit_deviation
        if deviations.size:
            F = F.copy()
            for columns, value in zip(
                model.suite.gyro_sensitivity_slices, deviations[k], strict=True
            ):
                F[:3, columns] = value * F_at_unit_deviation[:3, columns]
        P = F @ P @ F.T + Q.sum(axis=0)
        updates = []
        for i, rows_of_sensor in enumerate(rows):
            if is_measured[k, rows_of_sensor].any():
                update = _compute_update(P, H[k, rows_of_sensor], R[rows_of_sensor], i, considered)
                P = update.error_transition @ P @ update.error_transition.T
                P += (update.gain * update.noise) @ update.gain.T
                updates.append(update)
        yield _Step(F, Q, updates)


def _compute_update(P: Floats, H: Floats, R: Floats, sensor: int, considered: Ints) -> _Update:
    gain = np.array(np.linalg.solve(H @ P @ H.T + np.diag(R), H @ P).T, dtype=np.float64)
    gain[considered] = 0.0
    error_transition: Floats = np.eye(len(P)) - gain @ H
    return _Update(sensor, gain, error_transition, R)


def _discretize(model: FilterModel, rate: Floats) -> tuple[Floats, Floats]:
    """Return the transition matrix of a step and the process noise due to each state block.

    The body rate is constant. The transition matrix has shape (n, n). The process-noise covariances
    have shape (d, n, n), one for each of the d blocks with process noise.
    """
    from mgeo_attitude.filter.kernel import load_driver  # This import loads numba.

    suite, n_states = model.suite, model.suite.n_states
    A, n_dynamic, F = suite.dynamics_matrix(rate), suite.n_dynamic, np.eye(n_states)
    driven = []
    for _, density in _iterate_densities(suite):
        if density.any():
            F[:n_dynamic, :n_dynamic], block_noise = load_driver().discretize_compiled(
                A, density, model.step
            )
            driven.append(np.zeros((n_states, n_states)))
            driven[-1][:n_dynamic, :n_dynamic] = block_noise
    return F, np.array(driven)
