"""The reference filter: filterpy's Kalman filter on dense matrices, one design, full history.

Slow and plain on purpose. It shares with the compiled kernel only the declaration of the suite and
the tables of the run: F and Q come from Van Loan's matrix exponential, the attitude from scipy's
rotations, and all sensors update together.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from filterpy.kalman import KalmanFilter
from numpy.typing import ArrayLike
from scipy.linalg import block_diag, expm

from .._typing import Bools, Floats
from ..maneuvers.attitude import attitudes
from .model import FilterModel


@dataclass(frozen=True)
class FilterHistory:
    """A filter run from its start to convergence, n samples.

    Attributes
    ----------
    times : array, shape (n,)
        [s]
    trace : array, shape (n,)
        Weighted trace of the covariance.
    sigma : array, shape (n, n_states)
        1-sigma of every state.
    attitude : array, shape (n, 3, 3)
        GCRS to body.
    predicted_attitude : array, shape (n, 3, 3)
        Covariance of the attitude error [rad²], before the measurements of the sample.
    covariance : array, shape (n_states, n_states)
        Covariance at the end.
    blocks : tuple of str
        Names of the state's 3-vectors.
    converged : bool
        False where the run ended at the scenario's duration.
    """

    times: Floats
    trace: Floats
    sigma: Floats
    attitude: Floats
    predicted_attitude: Floats
    covariance: Floats
    blocks: tuple[str, ...]
    converged: bool

    @property
    def t_end(self) -> float:
        """First objective of equation (5) [s]."""
        return float(self.times[-1])


def reference_run(model: FilterModel, design: ArrayLike) -> FilterHistory:
    """Run the filter of equations (2) to (4) over one design, shape (4 m,)."""
    plan = model.schedule(np.atleast_2d(np.asarray(design, dtype=float)))
    rates, starts, over = plan.rates[0], plan.starts[0], plan.over[0]
    attitude = attitudes(rates, starts, model.n_steps, model.step, model.initial_attitude)
    H, R, seen = _measurements(model, attitude)

    n = model.suite.n_states
    kf = KalmanFilter(dim_x=n, dim_z=len(R))
    kf.x = np.zeros(n)  # one-dimensional: filterpy broadcasts its (n, 1) default when given H
    kf.P = np.diag(model.initial_sigma**2)
    trace, sigma = [float(model.weights @ np.diag(kf.P))], [model.initial_sigma]
    predicted = [kf.P[:3, :3]]
    covariances = [kf.P.copy()]
    converged, rule = False, model.rule
    for k in range(1, model.n_steps + 1):
        flown = np.flatnonzero(starts == k - 1)
        if flown.size:
            kf.F, kf.Q = van_loan(model, rates[flown[-1]])
        kf.predict()
        predicted.append(kf.P[:3, :3].copy())
        rows = seen[k]
        if rows.any():
            kf.update(np.zeros(rows.sum()), R=np.diag(R[rows]), H=H[k, rows])
        trace.append(float(model.weights @ np.diag(kf.P)))
        sigma.append(np.sqrt(np.diag(kf.P)))
        before = k - model.window_steps
        if rule != "trace":
            covariances.append(kf.P.copy())
        elif k >= over and before >= 0:
            converged = has_converged(
                trace[before], trace[k], model.relative_decrease, model.allow_rise
            )
            if converged:
                break
    end, covariance = len(trace) - 1, kf.P
    if rule != "trace":
        end = min(max(_converged_from(model, trace, sigma), over), end)
        converged, covariance = end < model.n_steps, covariances[end]
        trace, sigma, predicted = trace[: end + 1], sigma[: end + 1], predicted[: end + 1]
    return FilterHistory(
        times=model.times[: len(trace)],
        trace=np.array(trace),
        sigma=np.array(sigma),
        attitude=attitude[: len(trace)],
        predicted_attitude=np.array(predicted),
        covariance=covariance,
        blocks=model.suite.blocks,
        converged=converged,
    )


def _converged_from(model: FilterModel, trace: list[float], sigma: list[Floats]) -> int:
    """Step from which on the rule's condition holds for the rest of a whole run."""
    if model.rule == "settling":
        broken = np.flatnonzero(np.array(trace) > model.factor * trace[-1])
    else:
        broken = np.flatnonzero((np.array(sigma) > model.required_sigma).any(axis=1))
    return int(broken[-1]) + 1 if broken.size else 0


def has_converged(before: float, now: float, relative_decrease: float, allow_rise: bool) -> bool:
    """Equation (6) for the trace at both ends of the window."""
    fall = before - now
    return fall < relative_decrease * before and (allow_rise or fall >= 0.0)


def van_loan(model: FilterModel, omega: Floats) -> tuple[Floats, Floats]:
    """Exact F and Q of one step at constant body rate `omega` [rad/s], both (n_states, n_states).

    C. F. Van Loan, Computing integrals involving the matrix exponential, IEEE Transactions on
    Automatic Control 23 (1978) 395-404.
    """
    suite, m = model.suite, model.suite.n_dynamic
    A = suite.dynamics_matrix(omega)
    upper = np.block([[-A, np.diag(suite.diffusion())], [np.zeros((m, m)), A.T]])
    exponential = expm(upper * model.step)
    F = exponential[m:, m:].T
    Q = F @ exponential[:m, m:]
    constant = suite.n_states - m
    return block_diag(F, np.eye(constant)), block_diag(Q, np.zeros((constant, constant)))


def _measurements(model: FilterModel, attitude: Floats) -> tuple[Floats, Floats, Bools]:
    """H and the diagonal of R of all sensors' rows, and which rows are seen, at every sample."""
    H: list[Floats] = []
    R: list[float] = []
    seen: list[Bools] = []
    for index, sensor in enumerate(model.suite.sensors):
        v = np.einsum("kij,kj->ki", attitude, model.references[:, index])
        H.append(model.suite.measurement_matrix(sensor, v))
        R.extend(sigma**2 for sigma in sensor.noise())
        mask = model.available[:, index]
        view = sensor.field_of_view()
        if view is not None:
            boresight, half_angle = view
            mask = mask & (v @ boresight >= np.cos(half_angle))
        seen.extend([mask] * 3)
    return np.concatenate(H, axis=1), np.array(R), np.stack(seen, axis=1)
