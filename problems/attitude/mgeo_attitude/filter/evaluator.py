"""Both objectives of equation (5) for a batch of designs, compiled and threaded."""

from __future__ import annotations

import os
import warnings
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from .._typing import Floats, Ints
from ..maneuvers.schedule import Schedule
from .codegen import step_constants
from .jobs import separate, shared
from .keep_out import cone_constants, sun_clearance
from .kernel import lanes, load_driver, load_kernel
from .layout import layout, transition_pattern
from .model import FilterModel

#: The cosine of the angle to a Sun that has not shone.
_NEVER_SEEN = -2.0


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
    sun_angle : array, shape (n, n_cones)
        Least angle [rad] between the Sun, while it shines, and each axis that must stay off it,
        less the margin for the unknown attitude (`keep_out.sun_clearance`).
    t_required : array, shape (n,)
        Time from which on all required 1-sigmas are met until `t_end` [s]; infinite if they are not
        met then, or there are none.
    plan : Schedule
        What is flown.

    A covariance that lost positivity gives NaN in `t_end` and `trace`.
    """

    t_end: Floats
    trace: Floats
    variances: Floats
    covariance: Floats
    sun_angle: Floats
    t_required: Floats
    plan: Schedule


def evaluate(
    model: FilterModel,
    designs: ArrayLike,
    threads: int | None = None,
    history: bool = False,
    covariance: bool = False,
) -> Evaluation:
    """Run the covariance filter over every design, shape (n, 4 m).

    The result of a design depends on nothing but the model and the design: not on its neighbors in
    the batch, their order, or the number of threads.

    Parameters
    ----------
    threads : int, optional
        Default: the processors this process may use.
    history : bool
        Whether to return the variances at every step.
    covariance : bool
        Whether to return the covariances at the end.
    """
    plan = model.schedule(designs)
    stops, model_run = np.full(len(plan.rates), model.n_steps), model
    if model.rule != "trace":
        model_run = model.endless
        whole = _run(model_run, plan, stops, threads, factor=model.factor)
        settled = whole.settled if model.rule == "settling" else _required_from(whole)
        stops = np.clip(settled, plan.over, model.n_steps)
    ran = _run(model_run, plan, stops, threads, history, covariance)
    suite, monitors, n = model.suite, model.monitors, len(stops)
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
    sun = ran.watched[:, : len(monitors.cones)]
    sun_angle = np.where(monitors.cones, -sun, np.arccos(np.clip(sun, -1.0, 1.0)))
    t_required = np.full(n, np.inf)
    if monitors.states:
        met = ran.watched[:, -1] > 0.0
        t_required[met] = model.step * _required_from(ran)[met]
    full = _symmetric(ran.final, suite.n_states)
    return Evaluation(t_end, trace, ran.record, full, sun_angle, t_required, plan)


class _Ran(NamedTuple):
    """What the driver leaves of n designs; see `driver.run`."""

    end_step: Ints
    settled: Ints
    trace: Floats
    watched: Floats
    final: Floats
    record: Floats


def _run(
    model: FilterModel,
    plan: Schedule,
    stops: Ints,
    threads: int | None,
    history: bool = False,
    covariance: bool = False,
    factor: float = 0.0,
) -> _Ran:
    """Run the designs until they converge or stop, in whatever threads there are."""
    suite, n, monitors = model.suite, len(plan.rates), model.monitors
    kernel, driver = load_kernel(suite, model.gated, monitors), load_driver()
    at = layout(suite, model.gated, monitors)
    # A history is recorded step by step, so every design is then run by itself from the start.
    jobs = separate(n) if history else shared(plan.rates, plan.starts, plan.over, model.n_steps)
    n_jobs = len(jobs.design)
    record = np.full((n if history else 0, model.n_steps + 1, suite.n_states), np.nan)
    record[:, 0] = model.initial_sigma**2
    end_step, settled, trace = np.zeros(n, np.int64), np.zeros(n, np.int64), np.empty(n)
    watched, final = np.empty((n, monitors.total)), np.empty((n if covariance else 0, at.attitude))
    cones = cone_constants(model.cones, model.cone_sigmas)
    required = model.required_sigma[list(monitors.states)]
    arguments: tuple[Any, ...] = (
        (kernel.step.address, kernel.check.address, lanes()),
        tuple(at),
        (np.zeros(1, dtype=np.int64), np.zeros(n_jobs, dtype=np.int64)),
        jobs[:5],
        _states(model, (jobs.snapshot >= 0).sum(), at.rotation),
        (np.ascontiguousarray(plan.rates), np.ascontiguousarray(plan.starts), plan.over),
        (model.dynamics, suite.diffusion(), np.array(transition_pattern(suite)), model.step),
        model.table,
        step_constants(suite, model.weights, cones, required),
        (model.window_steps, model.relative_decrease, model.allow_rise, factor),
        (stops, end_step, settled),
        trace,
        (watched, final),
        record,
    )
    others = min(threads or available_threads(), n_jobs) - 1
    with ThreadPoolExecutor(max(others, 1)) as pool:  # it makes no thread before it needs one
        futures = [pool.submit(driver.run, *arguments) for _ in range(others)]
        driver.run(*arguments)
    for future in futures:
        future.result()
    twin = jobs.twin
    final = final[twin] if covariance else final
    return _Ran(end_step[twin], settled[twin], trace[twin], watched[twin], final, record)


def _required_from(ran: _Ran) -> Ints:
    """Step from which on the requirements are met; after the last one if they are not."""
    return ran.end_step + 1 - np.rint(ran.watched[:, -1]).astype(np.int64)


def _states(model: FilterModel, count: int, n_values: int) -> Floats:
    """Room for states that jobs leave, as `driver.save` does; the last one is that at time zero.

    Covariance, attitude, monitors and the trace over the last window.
    """
    states = np.zeros((count + 1, n_values + model.window_steps + 1))
    variances = model.initial_sigma**2
    start = [np.diag(variances)[np.tril_indices(len(variances))], model.initial_attitude.ravel()]
    start += [_monitors_at_start(model), np.cumsum(model.weights * variances)[-1:]]
    states[-1, : n_values + 1] = np.concatenate(start)
    return states


def _monitors_at_start(model: FilterModel) -> Floats:
    """What `layout.Monitors` says, at time zero."""
    values = np.empty(0)
    if len(model.cones):
        sun = model.sun[:1] @ model.initial_attitude.T
        covariance = np.diag(model.initial_sigma[:3] ** 2)[None]
        cosines = model.cones @ sun[0] if sun.any() else np.full(len(model.cones), _NEVER_SEEN)
        cones = zip(model.cones, model.cone_sigmas, strict=True)
        angles = [sun_clearance(axis, k, sun, covariance)[0] for axis, k in cones]
        excess = np.maximum(-np.pi, -np.array(angles))
        values = np.where(model.monitors.cones, excess, cosines)
    if not model.monitors.states:
        return values
    return np.append(values, float(np.all(model.initial_sigma <= model.required_sigma)))


def _symmetric(triangles: Floats, n: int) -> Floats:
    """Full matrices from lower triangles, shape (m, n (n + 1) / 2)."""
    row, column = np.tril_indices(n)
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
