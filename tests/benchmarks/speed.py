"""Time of one filter step and candidate: filterpy, NumPy and the generated kernel.

A useful step lies between the start of a design and its own end. Overhead of a batch (lanes without
a design, threads, Python) counts as time of its useful steps.
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
from .measure import Timing, interleaved

Floats = NDArray[np.float64]

_TEXTBOOK_STEPS = 500

Key = TypeVar("Key", bound=Hashable)


@dataclass(frozen=True)
class Task:
    """A callable to time and the number of useful filter steps that it does."""

    run: Callable[[], object]
    steps: int


def kernel(model: FilterModel, designs: Floats, threads: int) -> Task:
    """Return the evaluation of a batch by the kernel."""
    return Task(partial(evaluate, model, designs, threads), useful_steps(model, designs))


def predict_and_update(run: Callable[[textbook.Matrices], Floats]) -> Task:
    """Return predict and update of the paper's suite by filterpy or NumPy."""
    omega = np.radians([0.5, -0.3, 0.8])
    given = textbook.matrices(cases.model(cases.PAPER), omega, _TEXTBOOK_STEPS)
    return Task(partial(run, given), _TEXTBOOK_STEPS)


def useful_steps(model: FilterModel, designs: Floats) -> int:
    """Return the number of steps until the end of each design, summed over the designs."""
    return round(float(evaluate(model, designs).t_end.sum()) / model.step)


def step_tasks() -> dict[str, Task]:
    """Return the ways to do a filter step of the paper's suite, slowest first."""
    model, X = cases.model(cases.PAPER), cases.designs(360)
    return {
        "filterpy": predict_and_update(textbook.run_filterpy),
        "NumPy": predict_and_update(textbook.run_numpy),
        "kernel": kernel(model, X, threads=1),
        "kernel, two threads": kernel(model, X, threads=2),
    }


def growth_tasks() -> dict[str, Task]:
    """Return the kernel on one thread for suites of growing size."""
    return {
        name: kernel(cases.model(name), cases.designs(360), threads=1)
        for name in (*cases.SUITES, cases.FULL)
    }


def compare(tasks: Mapping[Key, Task], rounds: int) -> dict[Key, Timing]:
    """Time tasks in turn; return seconds per useful step."""
    timings = interleaved({key: task.run for key, task in tasks.items()}, rounds)
    return {
        key: Timing(timing.processor / tasks[key].steps, timing.wall / tasks[key].steps)
        for key, timing in timings.items()
    }
