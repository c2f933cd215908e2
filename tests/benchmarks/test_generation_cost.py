"""What a generation costs outside the problem, beside pymoo's NSGA-II with the same offspring.

Processor time rather than the clock's: the figure is about work, not about who else works.
"""

import statistics
import time

import numpy as np
import pytest
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.core.population import Population
from pymoo.core.problem import Problem
from pymoo.core.termination import NoTermination

from mgeo import MGEOCanonical, MGEODirected, MGEOReal, MGEOReal2, MGEOVar

N_VAR = 12
GENERATIONS = 40

# evaluations a walker and generation, and the member with so many walkers
MEMBERS = {
    "real": (12, lambda n: MGEOReal(0.1, n_runs=n)),
    "real, a-geo2": (12, lambda n: MGEOReal(0.1, "a-geo2", n)),
    "real, restarts": (12, lambda n: MGEOReal(0.1, n_runs=n, restart="archive", patience=2)),
    "real2": (25, lambda n: MGEOReal2(0.1, n_runs=n, n_steps=2)),
    "canonical": (12, lambda n: MGEOCanonical(n_runs=n, bits=1)),
    "var": (25, lambda n: MGEOVar(n_runs=n, bits=2, coding="gray")),
    "directed": (12, lambda n: MGEODirected(n_runs=n)),
}


class Shells(Problem):
    """Spherical fronts, one inside the other; it keeps account of its own time."""

    def __init__(self, n_obj):
        super().__init__(n_var=N_VAR, n_obj=n_obj, xl=0.0, xu=1.0)
        self.seconds = 0.0

    def _evaluate(self, X, out, *args, **kwargs):
        start = time.process_time()
        out["F"] = on_sphere(X[:, : self.n_obj] + 1e-3)
        out["F"] *= 1 + 0.02 * X[:, self.n_obj :].mean(axis=1, keepdims=True)
        self.seconds += time.process_time() - start


def on_sphere(directions):
    return directions / np.linalg.norm(directions, axis=1, keepdims=True)


def milliseconds(*algorithms):
    """Median over generations of each, without the problem's share.

    They take turns, so that whoever else works disturbs them alike.
    """
    costs = [[] for _ in algorithms]
    for _ in range(GENERATIONS):
        for algorithm, each in zip(algorithms, costs, strict=True):
            spent, start = algorithm.problem.seconds, time.process_time()
            algorithm.next()
            each.append(time.process_time() - start - (algorithm.problem.seconds - spent))
    return [1e3 * statistics.median(each) for each in costs]


@pytest.mark.benchmark
@pytest.mark.parametrize("n_obj", [2, 3])
@pytest.mark.parametrize("front", [100, 1000, 10_000])
@pytest.mark.parametrize("offspring", [12, 120, 360])
@pytest.mark.parametrize("member", MEMBERS)
def test_a_generation_costs_no_more_than_one_of_nsga2(
    member, offspring, front, n_obj, record_property
):
    each, build = MEMBERS[member]
    n_runs = max(1, offspring // each)
    offspring = n_runs * each
    nsga2 = NSGA2(pop_size=offspring).setup(Shells(n_obj), termination=NoTermination(), seed=1)
    ours = build(n_runs).setup(Shells(n_obj), termination=NoTermination(), seed=1)
    directions = np.abs(np.random.default_rng(0).standard_normal((front, n_obj)))
    F = 1.008 * on_sphere(directions + 1e-3)  # few candidates of a walk get below this shell
    ours.front.add(F, Population.new("X", np.full((front, N_VAR), 0.5), "F", F))
    before = len(ours.front)
    theirs, cost = milliseconds(nsga2, ours)
    record_property("milliseconds", cost)
    print(
        f"\n{offspring} offspring, {n_obj} objectives: NSGA-II {theirs:.2f} ms, {member} "
        f"{cost:.2f} ms ({cost / theirs:.2f}) with a front of {before} to {len(ours.front)}"
    )
    assert cost <= theirs
