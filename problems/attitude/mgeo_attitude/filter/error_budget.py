"""Error budget of a plan: contribution of each error source to the variances at the end.

A filter error is linear in its independent sources: initial errors, process noise of gyro and
sensor errors, measurement noise. The covariance at the end is therefore the sum of the covariances
that the sources cause separately *with the gains of the complete filter* (Gelb, Applied Optimal
Estimation, 1974, section 7.4, "error budget"). Variances add up; 1-sigmas do not. Without a source
the filter would use other gains, so that removing the source gains at least its contribution.

All states are computed together: the transposed error transition is propagated back from the end.
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
from mgeo_attitude.sensors.suite import Suite, list_block_units


class ErrorBudget(NamedTuple):
    """Contributions of s error sources to the variances of n states.

    Attributes
    ----------
    sources : tuple of str
        ``initial gyro bias``, ``noise of gyro``, ``drift of gyro bias``, ``noise of sun``...
    variances : array, shape (s, n_states)
        Contributions in squared filter units. The sum over the sources is the diagonal of the
        covariance.
    """

    sources: tuple[str, ...]
    variances: Floats


class _Update(NamedTuple):
    """Measurement update of one sensor: gain (n, m), I - K H (n, n), noise variances (m,)."""

    sensor: int
    gain: Floats
    error_transition: Floats
    noise: Floats


class _Step(NamedTuple):
    """Filter step: F (n, n), Q of each block with process noise (d, n, n), and the updates."""

    transition: Floats
    process_noise: Floats
    updates: list[_Update]


def compute_error_budget(model: FilterModel, design: ArrayLike, t_end: float) -> ErrorBudget:
    """Return the error budget of a nominal run of a design until `t_end`.

    The computation takes about 0.1 ms per filter step.

    Parameters
    ----------
    model : FilterModel
    design : array_like, shape (4 m,)
        Rates [deg/s] and duration [s] of each maneuver in turn.
    t_end : float
        End of the run [s].
    """
    suite, start = model.suite, model.initial_covariance
    driven = [block for block, density in _iterate_densities(suite) if density.any()]
    labels = {b: unit.label for b, unit in zip(suite.blocks, list_block_units(suite), strict=True)}
    n = suite.n_states
    adjoint, of_noise = np.eye(n), np.zeros((len(suite.sensors), n))
    of_drift = np.zeros((len(driven), n))
    for step in reversed(list(_iterate_steps(model, design, round(t_end / model.step)))):
        for update in reversed(step.updates):
            of_noise[update.sensor] += (adjoint @ update.gain) ** 2 @ update.noise
            adjoint = adjoint @ update.error_transition
        of_drift += np.einsum("ij,sjk,ik->si", adjoint, step.process_noise, adjoint, optimize=True)
        adjoint = adjoint @ step.transition
    initial = [f"initial {labels[b]}" for b in suite.blocks]
    if (model.initial_correlation == np.eye(n)).all():
        own = (adjoint**2 * model.initial_sigma**2).reshape(n, -1, 3).sum(axis=2).T
    else:  # Correlated initial errors have no separate contributions.
        initial = ["initial errors, correlated"]
        own = np.einsum("ij,jk,ik->i", adjoint, start, adjoint)[None]
    drifts = ["noise of gyro" if b == "attitude" else f"drift of {labels[b]}" for b in driven]
    noises = [f"noise of {sensor.name}" for sensor in suite.sensors]
    return ErrorBudget((*initial, *drifts, *noises), np.vstack([own, of_drift, of_noise]))


def _iterate_densities(suite: Suite) -> Iterator[tuple[str, Floats]]:
    """Yield each dynamic block and the process-noise density of that block alone, (n_dynamic,)."""
    density = suite.compute_noise_density()
    for i in range(0, len(density), 3):
        own = np.zeros_like(density)
        own[i : i + 3] = density[i : i + 3]
        yield suite.blocks[i // 3], own


def _iterate_steps(model: FilterModel, design: ArrayLike, n_steps: int) -> Iterator[_Step]:
    motion = Motion.from_design(model, design, model.n_steps)
    H, R, seen = build_measurement_model(model, motion.attitude, motion.rates)
    counts = np.cumsum([0, *(len(sensor.noise_sigmas()) for sensor in model.suite.sensors)])
    rows = [slice(*edges) for edges in pairwise(counts)]
    P, considered = model.initial_covariance, model.suite.considered_indices
    follows = model.sensitivity_factors[:, model.suite.find_sensitivity_columns(model.suite.gyro)]
    now, F, Q, unit = np.full(3, np.nan), np.empty(0), np.empty(0), np.empty(0)
    for k, rate in enumerate(motion.rates[:n_steps], 1):
        if (rate != now).any():
            now, (unit, Q) = rate, _discretize(model, rate)
            F = unit
        if follows.size:
            F = F.copy()
            for columns, value in zip(model.suite.gyro_sensitivity_slices, follows[k], strict=True):
                F[:3, columns] = value * unit[:3, columns]
        P = F @ P @ F.T + Q.sum(axis=0)
        updates = []
        for i, own in enumerate(rows):
            if seen[k, own].any():
                update = _compute_update(P, H[k, own], R[own], i, considered)
                P = update.error_transition @ P @ update.error_transition.T
                P += (update.gain * update.noise) @ update.gain.T
                updates.append(update)
        yield _Step(F, Q, updates)


def _compute_update(P: Floats, H: Floats, R: Floats, sensor: int, considered: Ints) -> _Update:
    gain = np.array(np.linalg.solve(H @ P @ H.T + np.diag(R), H @ P).T, dtype=np.float64)
    gain[considered] = 0.0
    rest: Floats = np.eye(len(P)) - gain @ H
    return _Update(sensor, gain, rest, R)


def _discretize(model: FilterModel, rate: Floats) -> tuple[Floats, Floats]:
    """Return F, shape (n, n), and Q of each block with process noise, shape (d, n, n)."""
    from mgeo_attitude.filter.kernel import load_driver  # This import loads numba.

    suite, n = model.suite, model.suite.n_states
    A, m, F = suite.dynamics_matrix(rate), suite.n_dynamic, np.eye(n)
    driven = []
    for _, density in _iterate_densities(suite):
        if density.any():
            F[:m, :m], own = load_driver().discretize_compiled(A, density, model.step)
            driven.append(np.zeros((n, n)))
            driven[-1][:m, :m] = own
    return F, np.array(driven)
