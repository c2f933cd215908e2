"""Timing of tasks on a busy machine: processor time, alternating tasks, best of several rounds."""

from __future__ import annotations

import gc
import math
import time
from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass
from typing import TypeVar

Key = TypeVar("Key", bound=Hashable)

#: Shortest duration of one measurement [s], for which a task is repeated. Measurements of similar
#: duration are equally likely to be undisturbed.
_MIN_DURATION = 0.1


@dataclass(frozen=True)
class Timing:
    """Shortest time of one run of a task over all rounds [s].

    Attributes
    ----------
    processor : float
        CPU time of all threads together. Other programs affect it only through the caches.
    wall : float
        Elapsed time, which is meaningful only on an idle machine.
    """

    processor: float
    wall: float


def time_interleaved(tasks: Mapping[Key, Callable[[], object]], rounds: int) -> dict[Key, Timing]:
    """Time every task once in each round, and return the shortest times as a dict keyed like
    `tasks`.

    Interruptions of one round affect all tasks alike. They only add time, so that the minimum is
    the best estimate. The first run of each task, which compiles code and fills caches, is not
    timed. A second run determines how often a measurement repeats the task.
    """
    repeats = {
        name: max(1, math.ceil(_MIN_DURATION / _time_second_run(task)))
        for name, task in tasks.items()
    }
    best = dict.fromkeys(tasks, Timing(math.inf, math.inf))
    gc.collect()
    gc.disable()
    try:
        for _ in range(rounds):
            for name, task in tasks.items():
                timing = _time(task, repeats[name])
                best[name] = Timing(
                    min(timing.processor, best[name].processor), min(timing.wall, best[name].wall)
                )
    finally:
        gc.enable()
    return best


def _time_second_run(task: Callable[[], object]) -> float:
    task()
    return max(_time(task, 1).wall, 1e-6)


def _time(task: Callable[[], object], repeats: int) -> Timing:
    wall, processor = time.perf_counter(), time.process_time()
    for _ in range(repeats):
        task()
    processor, wall = time.process_time() - processor, time.perf_counter() - wall
    return Timing(processor / repeats, wall / repeats)
