"""Monte Carlo simulation of a plan with the on-board filter."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from mgeo_attitude._typing import Bools, Floats, Ints
from mgeo_attitude.environment.directions import Cone, DirectionMotion
from mgeo_attitude.environment.environment import Environment
from mgeo_attitude.filter.evaluator import evaluate
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.filter.path_constraints import compute_monitored_angle
from mgeo_attitude.geometry.rotation import multiply
from mgeo_attitude.maneuvers.actuation import MagnetorquerDrive
from mgeo_attitude.maneuvers.motion import Motion
from mgeo_attitude.maneuvers.schedule import build_hold_design
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.scenario.validity import OutsideValidity, find_validity_violations
from mgeo_attitude.trajectory.trajectory import Trajectory
from numpy.typing import ArrayLike

from mgeo_calibration.estimation.innovation import Estimate
from mgeo_calibration.simulation.filter import ErrorStateFilter, FilterSettings
from mgeo_calibration.simulation.monte_carlo import MonteCarloResult, RunStatistics
from mgeo_calibration.simulators.kinematic import build_true_environment, build_true_model
from mgeo_calibration.simulators.simulated_run import (
    SimulatedRun,
    compute_true_motion,
    draw_errors,
    simulate_run,
)

#: Number of runs per batch. Threads would not help: each step consists of some hundred short NumPy
#: operations that hold the interpreter lock.
RUNS_PER_BATCH = 200

#: Approximate number of recorded samples.
N_RECORDED_SAMPLES = 600


def simulate(
    scenario: Scenario,
    design: ArrayLike,
    n_runs: int = 200,
    seed: int | np.random.Generator | None = None,
    *,
    filter_settings: FilterSettings | None = None,
    truth: Scenario | None = None,
    environment: Environment | None = None,
    end_time: float | None = None,
) -> MonteCarloResult:
    """Simulate Monte Carlo runs of a plan with the on-board filter, and return their estimation
    errors and filter statistics.

    The truth is nonlinear: exact rotations at the rates of the plan, misalignments as rotations, a
    Markov process as gyro bias, measurement noise, eclipses and fields of view. The filter starts
    from the scenario's attitude and zero errors, and the true initial errors are drawn from the
    scenario. The estimator is an error-state filter. After `t_end`, the last rate is held; if the
    scenario requires a slew back, the slew back follows and then the rate of the attitude law.

    The rates of magnetorquers depend on the attitude, so that each run has its own motion, as in
    `simulators.kinematic.simulate_telemetry`. The filter then propagates its covariance with the
    rates of the plan.

    Each run has its own random stream and does not depend on `n_runs`.

    Parameters
    ----------
    scenario : Scenario
        Model of the filter. The truth is drawn from the scenario unless `truth` is given.
    design : array_like, shape (4 m,)
        Rates [deg/s] and duration [s] of each maneuver, as in `AttitudeManeuverProblem`; ``[]`` for
        none.
    n_runs : int
        Number of runs.
    seed : int or Generator, optional
        Seed of the random streams. None draws fresh entropy.
    filter_settings : FilterSettings, optional
        Options of the filter.
    truth : Scenario, optional
        True scenario, if it differs from `scenario` in epoch, orbit, eclipse, gyro, sensors or
        initial uncertainty. All other keys must be equal. The filter uses every reading; with an
        orbit error, only readings at samples at which the orbit of `scenario` predicts a
        measurement.
    environment : Environment, optional
        Precomputed environment of the scenario.
    end_time : float, optional
        Time of the last estimate [s], at least `t_end`; default: duration of the scenario. Earlier
        results do not depend on `end_time`.

    Returns
    -------
    MonteCarloResult

    Warns
    -----
    OutsideValidity
        If the initial errors exceed the range in which the linear covariance is valid; see
        `find_validity_violations`.

    Raises
    ------
    ValueError
        If there are no runs, `design` has more than one dimension or is invalid, `truth` is
        incompatible, or the environment belongs to another scenario.
    NotImplementedError
        If a sensor does not define `predict_measurement`.

    Examples
    --------
    >>> from mgeo_attitude import Scenario
    >>> from mgeo_calibration import simulate
    >>> scenario = Scenario.from_dict({"preset": "paper", "duration": 400.0})
    >>> design = [0.5, 0.3, -0.2, 100.0, -0.3, 0.6, 0.2, 100.0, 0.2, -0.4, 0.7, 100.0]
    >>> result = simulate(scenario, design, n_runs=4, seed=1)
    >>> result.errors.shape
    (4, 401, 18)
    """
    if n_runs < 1:
        raise ValueError(f"n_runs = {n_runs!r}: expected at least 1")
    plan = np.asarray(design, dtype=float)
    if plan.ndim != 1:
        raise ValueError(f"design of shape {plan.shape}: expected one plan, shape (4 m,)")
    for reason in find_validity_violations(scenario):
        warnings.warn(reason, OutsideValidity, stacklevel=2)
    environment = environment or Environment.from_scenario(scenario)
    model = FilterModel.from_scenario(scenario, environment)
    true_model = model if truth is None else build_true_model(truth, scenario, environment)
    true_environment = build_true_environment(truth or scenario, scenario, environment)
    plan = plan if plan.size else build_hold_design(model.initial_rate)
    t_end = float(evaluate(model, plan).t_end[0])
    commanded_design = Trajectory(scenario, model, plan, t_end).commanded_design
    (variances,) = evaluate(model.full_duration_model, commanded_design, history=True).variances
    planned = Motion.from_design(model, commanded_design, model.n_steps)
    samples, n_constraint_samples = _select_samples(model, t_end), round(t_end / model.step) + 1
    if end_time is not None:
        samples = samples[model.times[samples] <= max(end_time, t_end)]

    def simulate_one(generator: np.random.Generator) -> SimulatedRun:
        random_errors, motion = draw_errors(true_model, model.n_steps, generator), planned
        if isinstance(model.slew_limits, MagnetorquerDrive):
            motion = compute_true_motion(model, plan, model.n_steps, random_errors.initial_errors)
        return simulate_run(true_model, motion, random_errors, true_environment)

    generators = np.random.default_rng(seed).spawn(n_runs)
    if n_runs == 1:
        generators *= 2  # NumPy would sum a single run in another order than many runs.
    n_parts = -(-n_runs // RUNS_PER_BATCH)
    ends = [len(generators) * part // n_parts for part in range(n_parts + 1)]
    result = []
    for first, last in pairwise(ends):
        runs = [simulate_one(generator) for generator in generators[first:last]]
        statistics = evaluate_filter(
            model,
            runs,
            filter_settings or FilterSettings(),
            samples,
            true_model,
            n_constraint_samples,
            planned.rates,
        )
        result.append(vars(statistics))
    return MonteCarloResult(
        blocks=model.suite.blocks,
        sensors=tuple(sensor.name for sensor in model.suite.sensors),
        n_components=tuple(len(sensor.noise_sigmas()) for sensor in model.suite.sensors),
        design=plan,
        t_end=t_end,
        times=model.times[samples],
        predicted_sigma=np.sqrt(variances[samples]),
        path_constraints=tuple(constraint.label for constraint in scenario.path_constraints),
        **{key: np.concatenate([part[key] for part in result])[:n_runs] for key in result[0]},
    )


def _select_samples(model: FilterModel, t_end: float) -> Ints:
    """Select about `N_RECORDED_SAMPLES` equally spaced samples to record, including the first, the
    last and `t_end`.
    """
    stride = -(-model.n_steps // N_RECORDED_SAMPLES)
    steps = [*range(0, model.n_steps, stride), round(t_end / model.step), model.n_steps]
    return np.unique(np.array(steps, dtype=np.int64))


def evaluate_filter(
    model: FilterModel,
    runs: Sequence[SimulatedRun],
    filter_settings: FilterSettings,
    samples: Ints,
    true_model: FilterModel | None = None,
    n_constraint_samples: int = 0,
    planned_rates: Floats | None = None,
) -> RunStatistics:
    """Run the filter on simulated measurements of a plan, and return its estimation errors and
    statistics.

    Each run has its own covariance. Only the rates with which the covariances are propagated are
    common to all runs.

    The path constraints are evaluated without margin for two attitudes, along the second axis of
    `violated_fractions`: first the true attitude under a controller that keeps the estimated
    attitude on the plan, then the true attitude of the simulated run. Each fraction is the share of
    the first `n_constraint_samples` samples at which the constraint is violated.

    Parameters
    ----------
    model : FilterModel
        Model of the filter.
    runs : sequence of SimulatedRun
    filter_settings : FilterSettings
    samples : array of int
        Samples to record, in increasing order. The filter stops at the last.
    true_model : FilterModel, optional
        True model with the path constraints to check. Default: model of the filter.
    n_constraint_samples : int
        Number of samples from the start at which the path constraints are checked.
    planned_rates : array, shape (n, 3), optional
        Rates for the covariance propagation [rad/s]. Default: rates of the first run.

    Returns
    -------
    RunStatistics
    """
    n_runs, m, suite, motion = len(runs), len(samples), model.suite, runs[0].motion
    rates = motion.rates if planned_rates is None else planned_rates
    constraint_model = true_model or model
    start, states, varying_states = (
        np.stack([getattr(run, name) for run in runs], axis=-1)
        for name in ("initial_rotation", "initial_states", "varying_states")
    )
    result = RunStatistics(
        errors=np.empty((n_runs, m, suite.n_states)),
        sigma=np.empty((n_runs, m, suite.n_states)),
        nees=np.empty((n_runs, m)),
        nis=np.zeros((n_runs, m, len(suite.sensors))),
        n_innovations=np.zeros((n_runs, m, len(suite.sensors)), dtype=np.int64),
        violated_fractions=np.zeros((n_runs, 2, len(constraint_model.path_constraints))),
    )
    readings = [run.readings for run in runs]
    if suite.environment_errors.has_orbit_error:  # An orbit error changes the eclipses.
        readings = [each.mask(model.available) for each in readings]
    estimates = ErrorStateFilter(suite, filter_settings).run(
        Estimate.from_model(model, n_runs),
        readings,
        rates,
        model.references,
        model.sensitivity_factors,
    )
    cones = [constraint.build_cone() for constraint in constraint_model.path_constraints]
    direction_motions = [
        constraint_model.compute_direction_motion(cone.direction, slice(n_constraint_samples))
        for cone in cones
    ]
    step_rotations = np.vstack([np.zeros(3), model.step * rates])
    d, row = 3 + varying_states.shape[1], 0
    true_attitude = motion.attitude[..., None]
    if any(run.motion is not motion for run in runs):  # Magnetorquer rates differ between runs.
        true_attitude = np.stack([run.motion.attitude for run in runs], axis=-1)
    for k, (before, after, nis) in enumerate(estimates):
        attitude = multiply(true_attitude[k], start)
        if k < n_constraint_samples:
            attitude_error = multiply(attitude, before.rotations[:, :, 0])
            steered = multiply(attitude_error, true_attitude[k])
            for index, (cone, direction_motion) in enumerate(
                zip(cones, direction_motions, strict=True)
            ):
                current = direction_motion.select_steps(slice(k, k + 1))
                # The controller keeps the estimated attitude on the plan. The true attitude then
                # differs from the plan by the estimation error.
                violations = [
                    _is_violated(cone, step_rotations[k], current, each)
                    for each in (steered, attitude)
                ]
                result.violated_fractions[:, :, index] += np.stack(violations, axis=1)
        has_innovation = ~np.isnan(nis.T)
        result.nis[:, row] += np.where(has_innovation, nis.T, 0.0)
        result.n_innovations[:, row] += has_innovation
        if k == samples[row]:
            states[3:d] = varying_states[k]
            e, P = after.compute_errors(attitude, states).T, after.covariance
            result.errors[:, row], result.sigma[:, row] = e, np.sqrt(np.einsum("iir->ri", P))
            normalized = np.linalg.solve(P.transpose(2, 0, 1), e[..., None])[..., 0]
            result.nees[:, row] = (e * normalized).sum(axis=1)
            row += 1
            if row == m:
                break
    result.violated_fractions[:] /= max(n_constraint_samples, 1)
    return result


def _is_violated(
    cone: Cone, rotation: Floats, direction_motion: DirectionMotion, attitude: Floats
) -> Bools:
    """Return a boolean mask of the runs, shape (r,), that violate a path constraint during the
    preceding step.

    Parameters
    ----------
    cone : Cone
        Path constraint, evaluated without margin.
    rotation : array, shape (3,)
        Rotation vector of the body in the step [rad].
    direction_motion : DirectionMotion
        Motion of the constrained direction in the step.
    attitude : array, shape (3, 3, r)
        Attitudes at the end of the step.
    """
    attitudes = np.moveaxis(attitude, -1, 0)
    body_motion = direction_motion.select_steps(
        np.zeros(len(attitudes), dtype=np.int64)
    ).rotate_to_body(attitudes)
    rotations, zero_covariance = (
        np.broadcast_to(rotation, body_motion.end.shape),
        np.zeros((len(attitudes), 3, 3)),
    )
    bound = cone.half_angle if cone.keep_in else -cone.half_angle
    return compute_monitored_angle(cone, 0.0, rotations, body_motion, zero_covariance) > bound
