"""What is compared: time per useful filter step, from filterpy to the multiply-add peak.

A useful step is one between a design's start and its own t_end. What a batch spends on lanes that
have run out of designs, on starting threads and in Python is time of its useful steps.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Generic, TypeVar

import numpy as np
from mgeo_attitude import FilterModel, evaluate
from numpy.typing import NDArray

from . import cases, peak, textbook
from .count import Count
from .measure import Timing, interleaved, used_by_others
from .scalar import evaluate_scalar

Floats = NDArray[np.float64]

MANEUVERS = (1, 3, 6, 12)

#: Other programs may use this many processors while elapsed times are taken.
_UNDISTURBED = 0.05

_TEXTBOOK_STEPS = 500
_SCALAR_DESIGNS = 24  # without lanes the time per step does not depend on how many there are
_PEAK_ITERATIONS = 1_000_000
_PEAK = "peak"

Key = TypeVar("Key", bound=Hashable)


@dataclass(frozen=True)
class Task:
    """Something to time, and the useful filter steps in it."""

    run: Callable[[], object]
    steps: int


@dataclass(frozen=True)
class Speed:
    """Time per useful step and candidate [ns].

    Attributes
    ----------
    processor : float
        Of all threads together: this is the time per step of one thread.
    wall : float
        Elapsed.
    """

    processor: float
    wall: float


@dataclass(frozen=True)
class Comparison(Generic[Key]):
    """Speeds measured side by side.

    Attributes
    ----------
    speeds : mapping
    peak : float
        Multiply-adds per ns that one core can do.
    others : float
        Processors that other programs used meanwhile, on average; NaN if not known.
    """

    speeds: Mapping[Key, Speed]
    peak: float
    others: float

    @property
    def undisturbed(self) -> bool:
        """Whether elapsed times mean anything, as far as is known."""
        return not self.others > _UNDISTURBED

    def fraction_of_peak(self, key: Key, count: Count) -> float:
        """Multiply-adds that the step needs over those possible in its time."""
        return count.multiplications / (self.speeds[key].processor * self.peak)


def kernel(model: FilterModel, designs: Floats, threads: int) -> Task:
    """The generated kernel over a batch, as the problem calls it."""
    return Task(partial(evaluate, model, designs, threads), useful_steps(model, designs))


def scalar(model: FilterModel, designs: Floats) -> Task:
    """The scalar loop over the first few of the designs."""
    few = designs[:_SCALAR_DESIGNS]
    return Task(partial(evaluate_scalar, model, few), useful_steps(model, few))


def predict_and_update(run: Callable[[textbook.Matrices], Floats]) -> Task:
    """filterpy or NumPy: predict and update of the paper's suite, nothing else."""
    omega = np.radians([0.5, -0.3, 0.8])
    given = textbook.matrices(cases.model(cases.PAPER), omega, _TEXTBOOK_STEPS)
    return Task(partial(run, given), _TEXTBOOK_STEPS)


def useful_steps(model: FilterModel, designs: Floats) -> int:
    """Steps until each design's own end, summed over the designs."""
    return round(float(evaluate(model, designs).t_end.sum()) / model.step)


def step_tasks() -> dict[str, Task]:
    """The ways to do a filter step of the paper's suite, slowest first."""
    model, X = cases.model(cases.PAPER), cases.designs(360)
    return {
        "filterpy": predict_and_update(textbook.run_filterpy),
        "NumPy": predict_and_update(textbook.run_numpy),
        "scalar loop": scalar(model, X),
        "kernel": kernel(model, X, threads=1),
        "kernel, two threads": kernel(model, X, threads=2),
    }


def growth_tasks() -> dict[tuple[str, int, str], Task]:
    """Other suites and numbers of maneuvers, by suite, maneuvers and way to do it.

    The scalar loop does not know the preset's states.
    """
    variants = [(name, 3) for name in cases.SUITES]
    variants += [(cases.PAPER, m) for m in MANEUVERS if m != 3]
    tasks: dict[tuple[str, int, str], Task] = {}
    for name, maneuvers in variants:
        model, X = cases.model(name), cases.designs(360, maneuvers)
        tasks[name, maneuvers, "scalar loop"] = scalar(model, X)
        tasks[name, maneuvers, "kernel"] = kernel(model, X, threads=1)
    tasks[cases.FULL, 3, "kernel"] = kernel(cases.model(cases.FULL), cases.designs(360), threads=1)
    return tasks


def compare(tasks: Mapping[Key, Task], rounds: int) -> Comparison[Key]:
    """Time tasks in turn, and the multiply-add peak among them."""
    runs: dict[Key | str, Callable[[], object]] = {key: task.run for key, task in tasks.items()}
    runs[_PEAK] = partial(peak.multiply_adds, _PEAK_ITERATIONS)
    start, others = time.perf_counter(), used_by_others()
    timings = interleaved(runs, rounds)
    others = (used_by_others() - others) / (time.perf_counter() - start)
    per_second = peak.multiply_adds_of(_PEAK_ITERATIONS) / timings[_PEAK].processor
    speeds = {key: _per_step(timings[key], task.steps) for key, task in tasks.items()}
    return Comparison(speeds, 1e-9 * per_second, others)


def _per_step(timing: Timing, steps: int) -> Speed:
    return Speed(1e9 * timing.processor / steps, 1e9 * timing.wall / steps)
