"""Reference filter: filterpy's Kalman filter with dense matrices, for one design with all samples.

The code is slow and simple on purpose, to verify the compiled kernel. Both share only the suite and
the orbit tables: here F and Q come from Van Loan's matrix exponential, attitudes from scipy's
rotations, and all sensors update together. filterpy does not support considered states; the update
is then written out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from filterpy.kalman import KalmanFilter
from numpy.typing import ArrayLike
from scipy.linalg import block_diag, expm

from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.filter.evaluator import evaluate
from mgeo_attitude.filter.history import FilterHistory, build_measurement_model
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.maneuvers.motion import compute_attitudes


@dataclass(frozen=True)
class ReferenceHistory(FilterHistory):
    """`FilterHistory` computed with filterpy.

    Attributes
    ----------
    predicted_attitude_covariance : array, shape (n, 3, 3)
        Covariance of the attitude error [rad²] before the measurements of each sample.
    """

    predicted_attitude_covariance: Floats


@dataclass(frozen=True)
class Agreement:
    """Difference between the compiled filter and the reference filter.

    Attributes
    ----------
    n_designs : int
        Number of designs.
    n_samples : int
        Number of samples at which the variances were compared.
    has_equal_ends : bool
        Whether t_end is equal for every design.
    max_difference : float
        Largest relative difference of a variance.
    """

    n_designs: int
    n_samples: int
    has_equal_ends: bool
    max_difference: float

    def is_within(self, tolerance: float) -> bool:
        """Return whether all t_end agree and the variances agree to a relative tolerance."""
        return self.has_equal_ends and self.max_difference <= tolerance

    def __str__(self) -> str:
        ends = "every t_end the same" if self.has_equal_ends else "NOT every t_end the same"
        return (
            f"{self.n_designs} random plans, {self.n_samples:,} samples: {ends}, variances differ by "
            f"{self.max_difference:.2g} of their size at most"
        )


def compare_filters(model: FilterModel, designs: ArrayLike) -> Agreement:
    """Compare `evaluate` with `run_reference_filter` over some designs.

    Parameters
    ----------
    model : FilterModel
    designs : array_like, shape (n, 4 m)
        Rates [deg/s] and duration [s] of each maneuver in turn.

    Examples
    --------
    >>> from mgeo_attitude import FilterModel, Scenario, agreement
    >>> scenario = Scenario.from_dict({"preset": "paper", "duration": 1000.0})
    >>> design = [0.5, 0.3, -0.2, 100.0, -0.3, 0.6, 0.2, 100.0, 0.2, -0.4, 0.7, 100.0]
    >>> agreement(FilterModel.from_scenario(scenario), [design]).difference < 1e-9
    True
    """
    X = np.atleast_2d(np.asarray(designs, dtype=float))
    result = evaluate(model, X, history=True)
    same_end, difference, samples = True, 0.0, 0
    for x, t_end, variances in zip(X, result.t_end, result.variances, strict=True):
        run = run_reference_filter(model, x)
        n = min(len(run.times), round(t_end / model.step) + 1)
        expected = run.sigma[:n] ** 2
        same_end &= bool(t_end == run.t_end)
        difference = max(difference, float(np.abs(variances[:n] / expected - 1.0).max()))
        samples += n
    return Agreement(len(X), samples, same_end, difference)


def run_reference_filter(model: FilterModel, design: ArrayLike) -> ReferenceHistory:
    """Run the filter of equations (2) to (4) over one design with filterpy.

    Parameters
    ----------
    model : FilterModel
    design : array_like, shape (4 m,)
        Rates [deg/s] and duration [s] of each maneuver in turn.

    Examples
    --------
    >>> from mgeo_attitude import FilterModel, Scenario, run_reference_filter
    >>> scenario = Scenario.from_dict({"preset": "paper", "duration": 600.0})
    >>> design = [0.5, 0.3, -0.2, 100.0, -0.3, 0.6, 0.2, 100.0, 0.2, -0.4, 0.7, 100.0]
    >>> history = run_reference_filter(FilterModel.from_scenario(scenario), design)
    >>> history.t_end
    600.0
    """
    plan = model.build_schedule(np.atleast_2d(np.asarray(design, dtype=float)))
    rates, starts, over = plan.rates[0], plan.starts[0], plan.maneuver_end_steps[0]
    attitude = compute_attitudes(rates, starts, model.n_steps, model.step, model.initial_attitude)
    stretch = np.searchsorted(starts, np.arange(model.n_steps), side="right") - 1
    H, R, seen = build_measurement_model(model, attitude, rates[stretch])
    counts = [len(sensor.noise_sigmas()) for sensor in model.suite.sensors]
    own = [slice(last - m, last) for m, last in zip(counts, np.cumsum(counts), strict=True)]

    follows = model.sensitivity_factors[:, model.suite.find_sensitivity_columns(model.suite.gyro)]
    n, considered = model.suite.n_states, model.suite.considered_indices
    kf = KalmanFilter(dim_x=n, dim_z=len(R))
    # A one-dimensional state is required: filterpy broadcasts its (n, 1) default when given H.
    kf.x = np.zeros(n)
    kf.P = model.initial_covariance
    trace, sigma = [float(model.weights @ np.diag(kf.P))], [model.initial_sigma]
    predicted = [kf.P[:3, :3]]
    covariances = [kf.P.copy()]
    converged, rule = False, model.rule
    for k in range(1, model.n_steps + 1):
        new_rate = np.flatnonzero(starts == k - 1)
        if new_rate.size or follows.size:
            kf.F, kf.Q = discretize_van_loan(model, rates[stretch[k - 1]], follows[k].tolist())
        kf.predict()
        predicted.append(kf.P[:3, :3].copy())
        rows = seen[k]
        if considered.size:
            for sensor in own:
                if rows[sensor].any():
                    kf.P = update_with_considered_states(
                        kf.P, H[k, sensor], np.diag(R[sensor]), considered
                    )
        elif rows.any():
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
        end = min(max(_find_convergence_step(model, trace, sigma), over), end)
        converged, covariance = end < model.n_steps, covariances[end]
        trace, sigma, predicted = trace[: end + 1], sigma[: end + 1], predicted[: end + 1]
    return ReferenceHistory(
        times=model.times[: len(trace)],
        trace=np.array(trace),
        sigma=np.array(sigma),
        attitude=attitude[: len(trace)],
        predicted_attitude_covariance=np.array(predicted),
        covariance=covariance,
        blocks=model.suite.blocks,
        converged=converged,
    )


def _find_convergence_step(model: FilterModel, trace: list[float], sigma: list[Floats]) -> int:
    """Return the step from which on the rule of the model is satisfied for the rest of the run."""
    if model.ends_with_last_maneuver:
        return 1
    if model.rule == "settling":
        broken = np.flatnonzero(np.array(trace) > model.settling_factor * trace[-1])
    else:
        broken = np.flatnonzero((np.array(sigma) > model.required_sigma).any(axis=1))
    return int(broken[-1]) + 1 if broken.size else 0


def update_with_considered_states(P: Floats, H: Floats, R: Floats, considered: Ints) -> Floats:
    """Return the covariance after an update with zero gain for the considered states.

    The update uses Joseph's form, which holds for any gain. Each sensor updates separately: a
    sensor that leaves a considered state unchanged does not make the next reading more certain, so
    that a joint update would give a smaller covariance.
    """
    K = np.linalg.solve(H @ P @ H.T + R, H @ P).T
    K[considered] = 0.0
    rest = np.eye(len(P)) - K @ H
    return rest @ P @ rest.T + K @ R @ K.T


def has_converged(
    start_trace: float, end_trace: float, relative_decrease: float, allow_rise: bool
) -> bool:
    """Return whether the trace has converged by equation (6).

    Parameters
    ----------
    start_trace, end_trace : float
        Trace at the start and the end of the window.
    relative_decrease : float
        Least fraction by which the trace falls while the run has not converged.
    allow_rise : bool
        Whether a trace that rose has converged.
    """
    fall = start_trace - end_trace
    return fall < relative_decrease * start_trace and (allow_rise or fall >= 0.0)


def discretize_van_loan(
    model: FilterModel, omega: Floats, sensitivity_factors: Sequence[float] = ()
) -> tuple[Floats, Floats]:
    """Return the exact F and Q of one step at constant body rate.

    C. F. Van Loan, Computing integrals involving the matrix exponential, IEEE Transactions on
    Automatic Control 23 (1978) 395-404.

    Parameters
    ----------
    model : FilterModel
    omega : array, shape (3,)
        Body rate [rad/s].
    sensitivity_factors : sequence of float
        Factors of the gyro's bias sensitivities, constant in the step; see `Suite.dynamics_matrix`.

    Returns
    -------
    F, Q : arrays, shape (n_states, n_states)
    """
    suite, m = model.suite, model.suite.n_dynamic
    A = suite.dynamics_matrix(omega, sensitivity_factors)
    upper = np.block([[-A, np.diag(suite.compute_noise_density())], [np.zeros((m, m)), A.T]])
    exponential = expm(upper * model.step)
    F = exponential[m:, m:].T
    Q = F @ exponential[:m, m:]
    constant = suite.n_states - m
    return block_diag(F, np.eye(constant)), block_diag(Q, np.zeros((constant, constant)))
