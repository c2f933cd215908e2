"""Reference filter for one design, with dense matrices and filterpy's Kalman filter.

The code is slow and simple, to verify the compiled filter. Both filters share only the sensor suite
and the orbit tables. The reference filter computes F and Q by Van Loan's matrix exponential and
attitudes by scipy's rotations, and updates with all sensors together. filterpy does not support
considered states, for which the module contains a separate update.
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
    """Time history of the reference filter, with the attitude covariance before each update.

    Attributes
    ----------
    predicted_attitude_covariance : array, shape (n, 3, 3)
        Covariance of the attitude error [rad²] before the measurements of each sample.
    """

    predicted_attitude_covariance: Floats


@dataclass(frozen=True)
class Agreement:
    """Result of comparing the compiled filter with the reference filter.

    Attributes
    ----------
    n_designs : int
        Number of compared designs.
    n_samples : int
        Number of samples at which the variances were compared.
    has_equal_ends : bool
        Whether both filters have the same t_end for every design.
    max_difference : float
        Largest relative difference of a variance.
    """

    n_designs: int
    n_samples: int
    has_equal_ends: bool
    max_difference: float

    def is_within(self, tolerance: float) -> bool:
        """Return True if the filters agree in end times and, within a tolerance, in variances.

        The tolerance limits the largest relative difference of a variance.
        """
        return self.has_equal_ends and self.max_difference <= tolerance


def compare_filters(model: FilterModel, designs: ArrayLike) -> Agreement:
    """Compare the end times and variances of the compiled filter and the reference filter.

    Both filters run each of n designs.

    Parameters
    ----------
    model : FilterModel
    designs : array_like, shape (n, 4 m)
        Rates [deg/s] and duration [s] of each maneuver in turn.

    Examples
    --------
    >>> from mgeo_attitude import FilterModel, Scenario, compare_filters
    >>> scenario = Scenario.from_dict({"preset": "paper", "duration": 1000.0})
    >>> design = [0.5, 0.3, -0.2, 100.0, -0.3, 0.6, 0.2, 100.0, 0.2, -0.4, 0.7, 100.0]
    >>> compare_filters(FilterModel.from_scenario(scenario), [design]).max_difference < 1e-9
    True
    """
    X = np.atleast_2d(np.asarray(designs, dtype=float))
    result = evaluate(model, X, history=True)
    has_equal_ends, max_difference, n_samples = True, 0.0, 0
    for x, t_end, variances in zip(X, result.t_end, result.variances, strict=True):
        history = run_reference_filter(model, x)
        n = min(len(history.times), round(t_end / model.step) + 1)
        expected = history.sigma[:n] ** 2
        has_equal_ends &= bool(t_end == history.t_end)
        max_difference = max(max_difference, float(np.abs(variances[:n] / expected - 1.0).max()))
        n_samples += n
    return Agreement(len(X), n_samples, has_equal_ends, max_difference)


def run_reference_filter(model: FilterModel, design: ArrayLike) -> ReferenceHistory:
    """Run the reference filter for one design, and return its time history.

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
    rates, starts, maneuver_end_step = plan.rates[0], plan.starts[0], plan.maneuver_end_steps[0]
    attitude = compute_attitudes(rates, starts, model.n_steps, model.step, model.initial_attitude)
    interval = np.searchsorted(starts, np.arange(model.n_steps), side="right") - 1
    H, R, is_measured = build_measurement_model(model, attitude, rates[interval])
    counts = [len(sensor.noise_sigmas()) for sensor in model.suite.sensors]
    sensor_rows = [slice(last - m, last) for m, last in zip(counts, np.cumsum(counts), strict=True)]

    deviations = model.sensitivity_factors[
        :, model.suite.find_sensitivity_columns(model.suite.gyro)
    ]
    n, considered = model.suite.n_states, model.suite.considered_indices
    kalman_filter = KalmanFilter(dim_x=n, dim_z=len(R))
    # The state must be one-dimensional, since filterpy broadcasts its default state of shape (n, 1)
    # if H is given.
    kalman_filter.x = np.zeros(n)
    kalman_filter.P = model.initial_covariance
    trace, sigma = [float(model.weights @ np.diag(kalman_filter.P))], [model.initial_sigma]
    predicted = [kalman_filter.P[:3, :3]]
    covariances = [kalman_filter.P.copy()]
    converged, rule = False, model.rule
    for k in range(1, model.n_steps + 1):
        rate_changes = np.flatnonzero(starts == k - 1)
        if rate_changes.size or deviations.size:
            kalman_filter.F, kalman_filter.Q = discretize_van_loan(
                model, rates[interval[k - 1]], deviations[k].tolist()
            )
        kalman_filter.predict()
        predicted.append(kalman_filter.P[:3, :3].copy())
        rows = is_measured[k]
        if considered.size:
            for sensor in sensor_rows:
                if rows[sensor].any():
                    kalman_filter.P = update_with_considered_states(
                        kalman_filter.P, H[k, sensor], np.diag(R[sensor]), considered
                    )
        elif rows.any():
            kalman_filter.update(np.zeros(rows.sum()), R=np.diag(R[rows]), H=H[k, rows])
        trace.append(float(model.weights @ np.diag(kalman_filter.P)))
        sigma.append(np.sqrt(np.diag(kalman_filter.P)))
        window_start = k - model.window_steps
        if rule != "trace":
            covariances.append(kalman_filter.P.copy())
        elif k >= maneuver_end_step and window_start >= 0:
            converged = has_converged(
                trace[window_start], trace[k], model.relative_decrease, model.allow_rise
            )
            if converged:
                break
    end, covariance = len(trace) - 1, kalman_filter.P
    if rule != "trace":
        end = min(max(_find_convergence_step(model, trace, sigma), maneuver_end_step), end)
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
    """Return the first step from which the convergence rule stays satisfied until the run ends."""
    if model.ends_with_last_maneuver:
        return 1
    if model.rule == "settling":
        violated = np.flatnonzero(np.array(trace) > model.settling_factor * trace[-1])
    else:
        violated = np.flatnonzero((np.array(sigma) > model.required_sigma).any(axis=1))
    return int(violated[-1]) + 1 if violated.size else 0


def update_with_considered_states(P: Floats, H: Floats, R: Floats, considered: Ints) -> Floats:
    """Update a covariance with a measurement, with zero gain for the considered states.

    The update has Joseph's form, which is valid for any gain. It must be called for one sensor at a
    time. A joint update of several sensors would give a smaller covariance, since a considered
    state is not improved between the sensors.
    """
    K = np.linalg.solve(H @ P @ H.T + R, H @ P).T
    K[considered] = 0.0
    error_transition = np.eye(len(P)) - K @ H
    return error_transition @ P @ error_transition.T + K @ R @ K.T


def has_converged(
    start_trace: float, end_trace: float, relative_decrease: float, allow_rise: bool
) -> bool:
    """Return True if the covariance trace has converged over the convergence window.

    The trace has converged if it decreased by less than a given fraction. A rise counts as
    convergence only if `allow_rise` is true. A NaN trace has not converged.

    Parameters
    ----------
    start_trace, end_trace : float
        Trace at the start and the end of the window.
    relative_decrease : float
        Fraction of the trace at the start; a run has converged if the decrease is less.
    allow_rise : bool
        Whether a run has also converged if the trace rose.
    """
    fall = start_trace - end_trace
    return fall < relative_decrease * start_trace and (allow_rise or fall >= 0.0)


def discretize_van_loan(
    model: FilterModel, omega: Floats, sensitivity_factors: Sequence[float] = ()
) -> tuple[Floats, Floats]:
    """Discretize the error dynamics at a constant body rate by Van Loan's exact method.

    The result is the transition matrix and the process-noise covariance of one filter step. Source:
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
