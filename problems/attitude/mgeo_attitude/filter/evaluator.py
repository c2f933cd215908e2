"""Both objectives of equation (5) for a batch of designs, compiled and threaded."""

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
from mgeo_attitude.filter.symbols import triangle
from mgeo_attitude.filter.variants import check_variants
from mgeo_attitude.maneuvers.schedule import Schedule

if TYPE_CHECKING:
    from mgeo_attitude.filter.jobs import Batch, Ran


@dataclass(frozen=True)
class Evaluation:
    """Results of n designs.

    Attributes
    ----------
    t_end : array, shape (n,)
        Time of convergence [s], or the scenario's duration.
    trace : array, shape (n,)
        Weighted trace of the covariance then.
    variances : array, shape (n, n_steps + 1, n_states) or (0, n_steps + 1, n_states)
        History of the variances, NaN after `t_end`, if asked for.
    covariance : array, shape (n, n_states, n_states) or (0, n_states, n_states)
        Covariance at `t_end`, if asked for.
    path_angle : array, shape (n, n_path_limits)
        Least angle [rad] between the direction and the axis of each path limit, less the margin for
        the unknown attitude; to keep in, the greatest, with the margin. See `path_limits.excess`.
    t_required : array, shape (n,)
        Time from which on all required 1-sigmas are met until `t_end` [s]; infinite if they are not
        met then, or there are none.
    wheel_load : array, shape (n, 2)
        Greatest momentum [N m s] and torque [N m] of a wheel until `t_end`, with a budget; see
        `momentum.MomentumBudget`. NaN without one.
    plan : Schedule
        What is flown.

    A covariance that lost positivity gives NaN in `t_end` and `trace`.

    Examples
    --------
    >>> from mgeo_attitude import FilterModel, Scenario, evaluate
    >>> design = [0.5, 0.3, -0.2, 400.0, -0.3, 0.6, 0.2, 500.0, 0.2, -0.4, 0.7, 600.0]
    >>> found = evaluate(FilterModel.from_scenario(Scenario.paper()), [design], covariance=True)
    >>> found.t_end, found.covariance.shape
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
    which: Ints | None = None,
    until: ArrayLike | None = None,
) -> Evaluation:
    """Run the covariance filter over every design, shape (n, 4 m).

    The result of a design depends on nothing but the model and the design: not on its neighbors in
    the batch, their order, or the number of threads.

    Designs may be flown by `variants` of the model, all with its one kernel: satellites that differ
    in numbers of gyro and sensors, such as noise and field of view, in initial and required
    1-sigmas, and in weights. A sensor of infinite noise is as good as absent, exactly.

    Parameters
    ----------
    threads : int, optional
        Default: the processors this process may use.
    history : bool
        Whether to return the variances at every step.
    covariance : bool
        Whether to return the covariances at the end.
    variants : sequence of FilterModel, optional
        Default: the model itself.
    which : array of int, shape (n,), optional
        The variant that flies each design; default: the first.
    until : array_like of int, shape (n,) or (), optional
        Steps at which runs end, from 1 to n_steps, in place of the rule of convergence: a maneuver
        that lasts longer is cut short, the last rate is held.

    Raises
    ------
    ValueError
        If the kernel of the model does not fit a variant; see `check_variants`.

    Examples
    --------
    >>> from mgeo_attitude import FilterModel, Scenario, evaluate
    >>> model = FilterModel.from_scenario(Scenario.paper())
    >>> design = [0.5, 0.3, -0.2, 400.0, -0.3, 0.6, 0.2, 500.0, 0.2, -0.4, 0.7, 600.0]
    >>> evaluate(model, [design, design], threads=2).t_end
    array([2337., 2337.])
    """
    from mgeo_attitude.filter.jobs import Batch, run  # imports numba, which takes long

    variants = variants or [model]
    check_variants(model, variants)
    plan = model.schedule(designs)
    n = len(plan.rates)
    flown_by = np.zeros(n, dtype=np.int64) if which is None else np.asarray(which, dtype=np.int64)
    batch = Batch(variants, flown_by, plan, threads or available_threads())
    last = np.full(n, model.n_steps)
    if until is None and model.ends_by_design:
        until = np.clip(plan.over, 1, model.n_steps)
    if until is not None:
        last[:] = until
        # all that lasts until then, so that designs of one plan and other ends are told apart
        lasting = batch._replace(plan=dataclasses.replace(plan, over=last))
        ran = run(model.unending, lasting, last, history, covariance)
    elif model.rule != "trace":
        whole = run(model.endless, batch, last, factor=model.factor)
        settled = whole.settled if model.rule == "settling" else _required_from(whole)
        stops = np.clip(settled, plan.over, model.n_steps)
        ran = run(model.endless, batch, stops, history, covariance)
    else:
        ran = run(model, batch, last, history, covariance)
    t_end, trace = model.step * ran.end_step.astype(float), ran.trace
    lost = np.isnan(trace)
    if lost.any():
        first = np.atleast_2d(np.asarray(designs, dtype=float))[np.argmax(lost)]
        warnings.warn(
            f"covariance lost positivity in {lost.sum()} of {n} designs, first {first.tolist()}; "
            "their objectives are NaN",
            RuntimeWarning,
            stacklevel=2,
        )
        t_end = np.where(lost, np.nan, t_end)
    t_required = np.full(n, np.inf)
    if model.monitors.states:
        met = ran.watched[:, -1] > 0.0
        t_required[met] = model.step * _required_from(ran)[met]
    full = _symmetric(ran.final, model.suite.n_states)
    angles, loads = _path_angles(model, ran.watched), _wheel_loads(model, batch, ran.end_step)
    return Evaluation(t_end, trace, ran.record, full, angles, t_required, loads, plan)


def _path_angles(model: FilterModel, watched: Floats) -> Floats:
    """`Evaluation.path_angle` of what the kernel has kept of path limits."""
    limits = model.monitors.limits
    path = watched[:, : len(limits)]
    return np.where([watch.inside for watch in limits], path, -path)


def _wheel_loads(model: FilterModel, batch: Batch, end_step: Ints) -> Floats:
    """`Evaluation.wheel_load` of runs that end at these steps."""
    if model.budget is None:
        return np.full((len(end_step), 2), np.nan)
    from mgeo_attitude.filter.wheel_load import wheel_loads  # imports numba

    return wheel_loads(model.budget, batch.plan, end_step, step=model.step, threads=batch.threads)


def _required_from(ran: Ran) -> Ints:
    """Step from which on the requirements are met; after the last one if they are not."""
    return ran.end_step + 1 - np.rint(ran.watched[:, -1]).astype(np.int64)


def _symmetric(triangles: Floats, n: int) -> Floats:
    """Full matrices from lower triangles, shape (m, n (n + 1) / 2)."""
    row, column = triangle(n)
    full = np.empty((len(triangles), n, n))
    full[:, row, column] = triangles
    full[:, column, row] = triangles
    return full


def available_threads() -> int:
    """Processors this process may use, and no more than ``NUMBA_NUM_THREADS`` says.

    joblib sets that variable in the processes it starts, so that they share the processors.
    """
    if hasattr(os, "sched_getaffinity"):
        processors = len(os.sched_getaffinity(0))
    else:
        processors = os.cpu_count() or 1
    limit = os.environ.get("NUMBA_NUM_THREADS", "")
    return min(processors, max(1, int(limit))) if limit.isdecimal() else processors
