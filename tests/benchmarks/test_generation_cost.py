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

from mgeo import MGEOReal

N_VAR = 12
GENERATIONS = 30


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


def milliseconds(algorithm):
    """Median over generations, without the problem's share."""
    costs = []
    for _ in range(GENERATIONS):
        spent, start = algorithm.problem.seconds, time.process_time()
        algorithm.next()
        costs.append(time.process_time() - start - (algorithm.problem.seconds - spent))
    return 1e3 * statistics.median(costs)


@pytest.mark.benchmark
@pytest.mark.parametrize("n_obj", [2, 3])
@pytest.mark.parametrize("front", [100, 1000, 10_000])
@pytest.mark.parametrize("offspring", [12, 120, 360])
def test_a_generation_costs_no_more_than_one_of_nsga2(offspring, front, n_obj, record_property):
    nsga2 = NSGA2(pop_size=offspring).setup(Shells(n_obj), termination=NoTermination(), seed=1)
    theirs = milliseconds(nsga2)

    ours = MGEOReal(0.1, n_runs=offspring // N_VAR)
    ours.setup(Shells(n_obj), termination=NoTermination(), seed=1)
    directions = np.abs(np.random.default_rng(0).standard_normal((front, n_obj)))
    F = 1.008 * on_sphere(directions + 1e-3)  # few candidates of a walk get below this shell
    ours.front.add(F, Population.new("F", F))
    before = len(ours.front)
    cost = milliseconds(ours)
    record_property("milliseconds", cost)
    print(
        f"\n{offspring} offspring, {n_obj} objectives: NSGA-II {theirs:.2f} ms, MGEOReal "
        f"{cost:.2f} ms with a front of {before} to {len(ours.front)}"
    )
    assert cost <= theirs
