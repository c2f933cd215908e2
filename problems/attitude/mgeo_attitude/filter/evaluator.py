"""Evaluation of a batch of designs by the compiled covariance filter, in several threads."""

from __future__ import annotations

import dataclasses
import os
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.filter.symbols import triangle_indices
from mgeo_attitude.filter.variants import validate_variants
from mgeo_attitude.maneuvers.schedule import Schedule

if TYPE_CHECKING:
    from mgeo_attitude.filter.jobs import Batch, BatchResult


@dataclass(frozen=True)
class Evaluation:
    """Results of the covariance filter for a batch of n designs.

    `t_end` and `trace` are NaN for a design whose covariance lost positive definiteness.

    Attributes
    ----------
    t_end : array, shape (n,)
        End of the run [s]: the convergence time, the given end step, or the scenario's duration.
    trace : array, shape (n,)
        Weighted trace of the covariance at `t_end`.
    variances : array, shape (n, n_steps + 1, n_states) or (0, n_steps + 1, n_states)
        Variances at every step, NaN after `t_end`. Empty unless requested.
    covariance : array, shape (n, n_states, n_states) or (0, n_states, n_states)
        Covariance at `t_end`. Empty unless requested.
    path_angle : array, shape (n, n_path_constraints)
        Extreme angle [rad] between the direction and the axis of each path constraint, with the
        margin for the attitude uncertainty. Keep-out: smallest angle minus the margin; keep-in:
        largest angle plus the margin. See `path_constraints.compute_monitored_angle`.
    t_required : array, shape (n,)
        Time [s] from which all required 1-sigmas remain satisfied until `t_end`. Infinite if a
        requirement is violated at `t_end` or if there are no requirements.
    wheel_load : array, shape (n, 2)
        Largest momentum [N m s] and torque [N m] of any wheel until `t_end`. NaN without a
        `MomentumBudget`.
    plan : Schedule
        Body rates of the designs.

    Examples
    --------
    >>> from mgeo_attitude import FilterModel, Scenario, evaluate
    >>> design = [0.5, 0.3, -0.2, 400.0, -0.3, 0.6, 0.2, 500.0, 0.2, -0.4, 0.7, 600.0]
    >>> result = evaluate(FilterModel.from_scenario(Scenario.paper()), [design], covariance=True)
    >>> result.t_end, result.covariance.shape
    (array([2337.]), (1, 18, 18))
    """

    t_end: Floats
    trace: Floats
    variances: Floats
    covariance: Floats
    path_angle: Floats
    t_required: Floats
    wheel_load: Floats
    plan: Schedule


def evaluate(
    model: FilterModel,
    designs: ArrayLike,
    threads: int | None = None,
    history: bool = False,
    covariance: bool = False,
    variants: Sequence[FilterModel] = (),
    variant_index: Ints | None = None,
    end_steps: ArrayLike | None = None,
) -> Evaluation:
    """Run the covariance filter for each design of a batch, and return an `Evaluation`.

    The result of a design depends only on the model and the design, not on the rest of the batch,
    the order of the designs, or the number of threads.

    Each design can be evaluated with a variant of the model. Variants share one compiled filter and
    may differ in parameters of sensors and gyro such as noise and field of view, in initial and
    required 1-sigmas, and in weights. A sensor with infinite noise is exactly equivalent to an
    absent sensor.

    Parameters
    ----------
    model : FilterModel
    designs : array_like, shape (n, 4 m)
        Rates [deg/s] and duration [s] of each maneuver in turn.
    threads : int, optional
        Default: the number of processors available to this process.
    history : bool
        Whether to return the variances at every step.
    covariance : bool
        Whether to return the covariances at the end.
    variants : sequence of FilterModel, optional
        Default: the model alone.
    variant_index : array of int, shape (n,), optional
        Index of the variant of each design. Default: the first variant.
    end_steps : array_like of int, shape (n,) or (), optional
        Steps at which the runs end, from 1 to n_steps, regardless of convergence. A maneuver that
        lasts longer is cut short. After the last maneuver its rate is held.

    Raises
    ------
    ValueError
        If a variant cannot use the compiled filter of the model; see `validate_variants`.

    Warns
    -----
    RuntimeWarning
        If the covariance of a design loses positive definiteness.

    Examples
    --------
    >>> from mgeo_attitude import FilterModel, Scenario, evaluate
    >>> model = FilterModel.from_scenario(Scenario.paper())
    >>> design = [0.5, 0.3, -0.2, 400.0, -0.3, 0.6, 0.2, 500.0, 0.2, -0.4, 0.7, 600.0]
    >>> evaluate(model, [design, design], threads=2).t_end
    array([2337., 2337.])
    """
    from mgeo_attitude.filter.jobs import Batch, run_batch  # This import loads numba.

    variants = variants or [model]
    validate_variants(model, variants)
    plan = model.build_schedule(designs)
    n = len(plan.rates)
    variant_indices = (
        np.zeros(n, dtype=np.int64)
        if variant_index is None
        else np.asarray(variant_index, dtype=np.int64)
    )
    batch = Batch(variants, variant_indices, plan, threads or count_available_threads())
    last_steps = np.full(n, model.n_steps)
    if end_steps is None and model.ends_with_last_maneuver:
        end_steps = np.clip(plan.maneuver_end_steps, 1, model.n_steps)
    if end_steps is not None:
        last_steps[:] = end_steps
        # The end becomes part of the schedule, since equal schedules are run only once.
        batch_with_ends = batch._replace(
            plan=dataclasses.replace(plan, maneuver_end_steps=last_steps)
        )
        result = run_batch(
            model.nonconverging_model, batch_with_ends, last_steps, history, covariance
        )
    elif model.rule != "trace":
        full_run = run_batch(
            model.full_duration_model, batch, last_steps, settling_factor=model.settling_factor
        )
        settled = (
            full_run.settling_step if model.rule == "settling" else _find_required_step(full_run)
        )
        end_steps_by_rule = np.clip(settled, plan.maneuver_end_steps, model.n_steps)
        result = run_batch(model.full_duration_model, batch, end_steps_by_rule, history, covariance)
    else:
        result = run_batch(model, batch, last_steps, history, covariance)
    t_end, trace = model.step * result.end_step.astype(float), result.trace
    is_lost = np.isnan(trace)
    if is_lost.any():
        first = np.atleast_2d(np.asarray(designs, dtype=float))[np.argmax(is_lost)]
        warnings.warn(
            f"the covariance lost positive definiteness in {is_lost.sum()} of {n} designs, first "
            f"{first.tolist()}. The objectives of these designs are NaN",
            RuntimeWarning,
            stacklevel=2,
        )
        t_end = np.where(is_lost, np.nan, t_end)
    t_required = np.full(n, np.inf)
    if model.monitors.states:
        is_satisfied = result.monitors[:, -1] > 0.0
        t_required[is_satisfied] = model.step * _find_required_step(result)[is_satisfied]
    full = _expand_triangles(result.covariance, model.suite.n_states)
    angles, loads = (
        _compute_path_angles(model, result.monitors),
        _compute_wheel_loads(model, batch, result.end_step),
    )
    return Evaluation(t_end, trace, result.variances, full, angles, t_required, loads, plan)


def _compute_path_angles(model: FilterModel, monitor_values: Floats) -> Floats:
    path_monitors = model.monitors.paths
    monitored_angles = monitor_values[:, : len(path_monitors)]
    is_keep_in = [monitor.keep_in for monitor in path_monitors]
    return np.where(is_keep_in, monitored_angles, -monitored_angles)


def _compute_wheel_loads(model: FilterModel, batch: Batch, end_step: Ints) -> Floats:
    if model.momentum_budget is None:
        return np.full((len(end_step), 2), np.nan)
    from mgeo_attitude.filter.wheel_load import compute_wheel_loads  # This import loads numba.

    return compute_wheel_loads(
        model.momentum_budget, batch.plan, end_step, step=model.step, threads=batch.threads
    )


def _find_required_step(result: BatchResult) -> Ints:
    """Return, for each design, the first step from which all required 1-sigmas stay satisfied.

    If a requirement is violated at the end of the run, the result is one step past the end.
    """
    return result.end_step + 1 - np.rint(result.monitors[:, -1]).astype(np.int64)


def _expand_triangles(triangles: Floats, n: int) -> Floats:
    row, column = triangle_indices(n)
    full = np.empty((len(triangles), n, n))
    full[:, row, column] = triangles
    full[:, column, row] = triangles
    return full


def count_available_threads() -> int:
    """Return the number of processors that this process may use.

    The environment variable NUMBA_NUM_THREADS lowers the number. joblib sets the variable in its
    worker processes, so that the processes share the processors.
    """
    if hasattr(os, "sched_getaffinity"):
        processors = len(os.sched_getaffinity(0))
    else:
        processors = os.cpu_count() or 1
    max_threads = os.environ.get("NUMBA_NUM_THREADS", "")
    return min(processors, max(1, int(max_threads))) if max_threads.isdecimal() else processors
