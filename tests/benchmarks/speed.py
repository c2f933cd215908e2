"""Time of one filter step of one candidate with filterpy, NumPy and the generated kernel.

A useful step lies between the start of a design and its end. Overhead of a batch (vector lanes
without a design, threads, Python) counts as time of the useful steps.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import TypeVar

import numpy as np
from mgeo_attitude import FilterModel, evaluate
from numpy.typing import NDArray

from . import cases, textbook
from .measure import Timing, time_interleaved

Floats = NDArray[np.float64]

_TEXTBOOK_STEPS = 500

Key = TypeVar("Key", bound=Hashable)


@dataclass(frozen=True)
class Task:
    """Function to time, and the number of useful filter steps that it computes."""

    run: Callable[[], object]
    steps: int


def build_kernel_task(model: FilterModel, designs: Floats, threads: int) -> Task:
    """Return the task of evaluating designs with the kernel."""
    return Task(partial(evaluate, model, designs, threads), count_useful_steps(model, designs))


def build_loop_task(run: Callable[[textbook.FilterMatrices], Floats]) -> Task:
    """Return the task of running a loop from `textbook` with the paper's suite."""
    omega = np.radians([0.5, -0.3, 0.8])
    matrices = textbook.build_matrices(cases.build_model(cases.PAPER), omega, _TEXTBOOK_STEPS)
    return Task(partial(run, matrices), _TEXTBOOK_STEPS)


def count_useful_steps(model: FilterModel, designs: Floats) -> int:
    """Return the number of steps until the end of each design, summed over the designs."""
    return round(float(evaluate(model, designs).t_end.sum()) / model.step)


def build_step_tasks() -> dict[str, Task]:
    """Return the implementations of a filter step of the paper's suite by name, slowest first."""
    model, X = cases.build_model(cases.PAPER), cases.draw_designs(360)
    return {
        "filterpy": build_loop_task(textbook.run_filterpy),
        "NumPy": build_loop_task(textbook.run_numpy),
        "kernel": build_kernel_task(model, X, threads=1),
        "kernel, two threads": build_kernel_task(model, X, threads=2),
    }


def build_growth_tasks() -> dict[str, Task]:
    """Return the kernel tasks on one thread by suite, in order of increasing size."""
    return {
        name: build_kernel_task(cases.build_model(name), cases.draw_designs(360), threads=1)
        for name in (*cases.SUITES, cases.FULL)
    }


def time_tasks(tasks: Mapping[Key, Task], rounds: int) -> dict[Key, Timing]:
    """Time tasks in alternation, and return the seconds per useful step by task."""
    timings = time_interleaved({key: task.run for key, task in tasks.items()}, rounds)
    return {
        key: Timing(timing.processor / tasks[key].steps, timing.wall / tasks[key].steps)
        for key, timing in timings.items()
    }
