"""Time of a generation outside the problem, compared with pymoo's NSGA-II with as many offspring.

``python -m tests.benchmarks.generation_cost`` measures all cases on an idle machine within a few
minutes, and prints the table that docs/validation/performance.md summarizes. Processor time is
measured, because it does not depend on other programs.
"""

from __future__ import annotations

import itertools
import platform
import statistics
import sys
import time
from collections.abc import Callable, Mapping
from datetime import UTC, datetime
from importlib.metadata import version
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.core.algorithm import Algorithm
from pymoo.core.population import Population
from pymoo.core.problem import Problem
from pymoo.core.termination import NoTermination

from mgeo import MGEOCanonical, MGEODirected, MGEOReal, MGEOReal2, MGEOVar

from .pages import format_table
from .table import get_processor_name

N_VAR = 12
GENERATIONS = 40

#: Evaluations per walker and generation, and function that builds the variant with n walkers.
VARIANTS: dict[str, tuple[int, Callable[[int], Any]]] = {
    "real": (12, lambda n: MGEOReal(0.1, n_walkers=n)),
    "real, a-geo2": (12, lambda n: MGEOReal(0.1, "a-geo2", n)),
    "real, restarts": (12, lambda n: MGEOReal(0.1, n_walkers=n, restart="archive", patience=2)),
    "real2": (25, lambda n: MGEOReal2(0.1, n_walkers=n, n_steps=2)),
    "canonical": (12, lambda n: MGEOCanonical(n_walkers=n, bits=1)),
    "var": (25, lambda n: MGEOVar(n_walkers=n, bits=2, coding="gray")),
    "directed": (3, lambda n: MGEODirected(n_walkers=n)),
}
OFFSPRING = (12, 120, 360)
FRONTS = (100, 1000, 10_000)
OBJECTIVES = (2, 3)


class Cost(NamedTuple):
    """Times of one generation in milliseconds, and sizes of the front before and after."""

    ours: float
    theirs: float
    before: int
    after: int

    @property
    def ratio(self) -> float:
        return self.ours / self.theirs


class Shells(Problem):
    """Problem with concentric spherical fronts, which measures its own processor time."""

    def __init__(self, n_obj: int) -> None:
        super().__init__(n_var=N_VAR, n_obj=n_obj, xl=0.0, xu=1.0)
        self.seconds = 0.0

    def _evaluate(self, X, out, *args, **kwargs):  # type: ignore[no-untyped-def]
        start = time.process_time()
        out["F"] = normalize(X[:, : self.n_obj] + 1e-3)
        out["F"] *= 1 + 0.02 * X[:, self.n_obj :].mean(axis=1, keepdims=True)
        self.seconds += time.process_time() - start


def normalize(directions: NDArray[np.float64]) -> NDArray[np.float64]:
    lengths: NDArray[np.float64] = np.linalg.norm(directions, axis=1, keepdims=True)
    return directions / lengths


def measure_cost(variant: str, offspring: int, front: int, n_obj: int) -> Cost:
    """Return the times of a generation of a variant and of NSGA-II, for one number of offspring,
    front size and number of objectives.

    The algorithms alternate, so that interruptions affect both.
    """
    n_evaluations, build = VARIANTS[variant]
    n_walkers = max(1, offspring // n_evaluations)
    nsga2 = NSGA2(pop_size=n_walkers * n_evaluations)
    ours = build(n_walkers)
    for algorithm in (nsga2, ours):
        algorithm.setup(Shells(n_obj), termination=NoTermination(), seed=1)
    directions = np.abs(np.random.default_rng(0).standard_normal((front, n_obj)))
    F = 1.008 * normalize(directions + 1e-3)  # Few candidates improve on this shell.
    ours.front.add(F, Population.new("X", np.full((front, N_VAR), 0.5), "F", F))
    before = len(ours.front)
    theirs, milliseconds = _measure_generation_times(nsga2, ours)
    return Cost(milliseconds, theirs, before, len(ours.front))


def _measure_generation_times(*algorithms: Algorithm) -> list[float]:
    """Return the median time of a generation of each algorithm, without the time of the problem."""
    costs: list[list[float]] = [[] for _ in algorithms]
    for _ in range(GENERATIONS):
        for algorithm, each in zip(algorithms, costs, strict=True):
            spent, start = algorithm.problem.seconds, time.process_time()
            algorithm.next()
            each.append(time.process_time() - start - (algorithm.problem.seconds - spent))
    return [1e3 * statistics.median(each) for each in costs]


def build_cost_table(costs: Mapping[tuple[str, int, int, int], Cost]) -> str:
    """Return the Markdown table of the smallest and largest ratio of each variant, by number of
    offspring.
    """
    rows = []
    for variant in VARIANTS:
        cells = []
        for offspring in OFFSPRING:
            ratios = [c.ratio for key, c in costs.items() if key[:2] == (variant, offspring)]
            cells.append(f"{min(ratios):.2f} to {max(ratios):.2f}")
        rows.append((variant, *cells))
    theirs = []
    for offspring in OFFSPRING:
        times = [c.theirs for key, c in costs.items() if key[1] == offspring]
        theirs.append(f"{min(times):.1f} to {max(times):.1f} ms")
    rows.append(("NSGA-II", *theirs))
    head = ("variant", *(f"{offspring} offspring" for offspring in OFFSPRING))
    return format_table(head, rows)


def main() -> None:
    keys = list(itertools.product(VARIANTS, OFFSPRING, FRONTS, OBJECTIVES))
    costs = {key: measure_cost(*key) for key in keys}
    description = (
        f"{get_processor_name()}, Python {platform.python_version()}, numpy {version('numpy')}, "
        f"pymoo {version('pymoo')}; {datetime.now(UTC):%Y-%m-%d}; median of {GENERATIONS} "
        "generations."
    )
    tables = f"{description}\n\n{build_cost_table(costs)}"
    sys.stdout.write(f"{tables}\n")


if __name__ == "__main__":
    main()
