"""Both objectives of equation (5) for a batch of designs, compiled and threaded."""

from __future__ import annotations

import os
import warnings
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .codegen import step_constants
from .jobs import separate, shared
from .kernel import load_kernel
from .model import FilterModel
from .timeline import decode, maneuver_steps

Floats = NDArray[np.float64]


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

    A covariance that lost positivity gives NaN in `t_end` and `trace`.
    """

    t_end: Floats
    trace: Floats
    variances: Floats


def evaluate(
    model: FilterModel, designs: ArrayLike, threads: int | None = None, history: bool = False
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
    """
    rates, durations = decode(designs)
    starts, over = maneuver_steps(durations, model.step)
    suite, n = model.suite, len(rates)
    kernel = load_kernel(suite, model.gated)
    rest, *unit = (suite.dynamics_matrix(omega) for omega in np.vstack([np.zeros(3), np.eye(3)]))
    # A history is recorded step by step, so every design is then run by itself from the start.
    jobs = separate(n) if history else shared(rates, starts, over, model.n_steps)
    record = np.full((n if history else 0, model.n_steps + 1, suite.n_states), np.nan)
    record[:, 0] = model.initial_sigma**2
    end_step, trace = np.zeros(n, dtype=np.int64), np.empty(n)
    # covariance, attitude and the trace over the last window
    snapshot = kernel.ROTATION + model.window_steps + 1
    arguments: tuple[Any, ...] = (
        np.zeros(1, dtype=np.int64),
        np.zeros(len(jobs.design), dtype=np.int64),
        jobs.design,
        jobs.begin,
        jobs.end,
        jobs.parent,
        jobs.snapshot,
        np.empty(((jobs.snapshot >= 0).sum(), snapshot)),
        np.ascontiguousarray(rates),
        starts,
        over,
        np.ascontiguousarray([rest, *(matrix - rest for matrix in unit)]),
        suite.diffusion(),
        model.references.reshape(len(model.references), -1),
        np.ascontiguousarray(model.available[:, model.gated], dtype=float),
        model.initial_sigma**2,
        step_constants(suite, model.weights),
        model.window_steps,
        model.relative_decrease,
        model.step,
        end_step,
        trace,
        record,
        kernel.LANES,
    )
    workers = max(1, min(threads or available_threads(), len(jobs.design)))
    if workers == 1:
        kernel.run(*arguments)
    else:
        with ThreadPoolExecutor(workers) as pool:
            for future in [pool.submit(kernel.run, *arguments) for _ in range(workers)]:
                future.result()
    t_end, trace = model.times[end_step[jobs.twin]], trace[jobs.twin]
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
    return Evaluation(t_end, trace, record)


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
