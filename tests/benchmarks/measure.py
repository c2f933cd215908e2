"""Timing that survives a busy machine: processor time, interleaved, best of several rounds."""

from __future__ import annotations

import gc
import math
import time
from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass
from typing import TypeVar

Key = TypeVar("Key", bound=Hashable)

#: A task is repeated until one measurement takes this long [s]: measurements of like length have
#: like chances of an undisturbed moment.
_SHORTEST = 0.1


@dataclass(frozen=True)
class Timing:
    """Least time of one run of a task over all rounds [s].

    Attributes
    ----------
    processor : float
        CPU time of all threads together, which other programs affect through caches only.
    wall : float
        Elapsed time, meaningful on an idle machine only.
    """

    processor: float
    wall: float


def interleaved(tasks: Mapping[Key, Callable[[], object]], rounds: int) -> dict[Key, Timing]:
    """Time every task once a round, so that what disturbs one round disturbs all tasks alike.

    Interference only ever adds time, hence the minimum. A first run of each task, in which code is
    compiled and caches fill, is not timed; a second one sets how often a measurement repeats it.
    """
    repeats = {name: max(1, math.ceil(_SHORTEST / _warm(task))) for name, task in tasks.items()}
    best = dict.fromkeys(tasks, Timing(math.inf, math.inf))
    gc.collect()
    gc.disable()
    try:
        for _ in range(rounds):
            for name, task in tasks.items():
                timing = _timed(task, repeats[name])
                best[name] = Timing(
                    min(timing.processor, best[name].processor), min(timing.wall, best[name].wall)
                )
    finally:
        gc.enable()
    return best


def _warm(task: Callable[[], object]) -> float:
    """Elapsed time of the second run [s]."""
    task()
    return max(_timed(task, 1).wall, 1e-6)


def _timed(task: Callable[[], object], repeats: int) -> Timing:
    wall, processor = time.perf_counter(), time.process_time()
    for _ in range(repeats):
        task()
    processor, wall = time.process_time() - processor, time.perf_counter() - wall
    return Timing(processor / repeats, wall / repeats)
