"""What COCO's own observer writes of a run: data that its post-processing, `cocopp`, reads."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from pymoo.core.population import Population
from pymoo.core.problem import Problem

from mgeo.benchmarks.coco import CocoProblem, observed

Watch = Callable[[Population, Any], object]


def run_folder(folder: Path, problem: Problem, seed: int) -> Path:
    """Where the data of a run go, below those of its algorithm.

    Raises
    ------
    ValueError : if the problem is none of COCO's.
    """
    if not isinstance(problem, CocoProblem):
        raise ValueError(
            f"data for COCO of {problem.name()}: expected one of COCO's functions, "
            "coco:SUITE/fN/dN/iN"
        )
    return folder / f"{problem.name().replace(' ', '-')}-seed{seed}"


@contextmanager
def coco_data(problem: CocoProblem, place: Path, algorithm: str, n_eval: int) -> Iterator[Watch]:
    """Shows COCO's observer the first `n_eval` evaluations of a run.

    It evaluates them once more, by itself: its functions take microseconds. The folder is there
    when the run is over, whole, in place of an earlier one, or not at all.

    Parameters
    ----------
    place : folder of the run's data.
    algorithm : its name there.

    Yields
    ------
    What takes each batch that has been evaluated.
    """
    # not within the algorithm's folder: what a killed process leaves there would be read
    part = place.parent.with_name(f".{place.parent.name}-{place.name}-{os.getpid()}")
    shutil.rmtree(part, ignore_errors=True)
    left = n_eval
    with observed(problem, part, algorithm) as function:

        def watch(population: Population, _: Any = None) -> None:
            nonlocal left
            for x in population.get("X")[: max(left, 0)].astype(float):
                function(x)
            left -= len(population)

        try:
            yield watch
        except BaseException:
            shutil.rmtree(part, ignore_errors=True)
            raise
    shutil.rmtree(place, ignore_errors=True)
    place.parent.mkdir(parents=True, exist_ok=True)
    part.rename(place)
