"""The claims of docs/performance.md on large runs at a size that can be tested every time."""

import statistics
import sys
import time

import numpy as np
import pytest
from pymoo.core.population import Population
from pymoo.problems.many import DTLZ2

from mgeo import MGEOReal
from mgeo.runs.solve import set_up

from . import load

GENERATIONS = 30
linux = pytest.mark.skipif(sys.platform != "linux", reason="it asks /proc")


def with_front(points):
    """A run whose front has so many points, all over the true one."""
    problem = DTLZ2(n_var=6, n_obj=3)
    algorithm = set_up(problem, MGEOReal(**load.PARAMETERS), 10**7, seed=1)
    algorithm.next()
    X = np.random.default_rng(1).random((points, 6))
    X[:, 2:] = 0.5
    population = Population.new("X", X)
    algorithm.evaluator.eval(problem, population)
    algorithm.front.add(population.get("F"), population)
    algorithm.next()
    assert points - 20 < len(algorithm.front)  # but for those that rounding has put behind others
    return algorithm


@pytest.mark.benchmark  # it is of time, which a busy machine can turn
def test_a_large_front_does_not_dominate_a_generation():
    """Processor time of bare generations, by turns, with 1,000 and 50,000 points.

    Twice as long is what moving 50,000 points takes; comparing all with all would be seen.
    """
    sizes = 1_000, 50_000
    runs = [with_front(points) for points in sizes]
    costs = [[], []]
    for _ in range(GENERATIONS):
        for algorithm, each in zip(runs, costs, strict=True):
            start = time.process_time()
            algorithm.next()
            each.append(time.process_time() - start)
    small, large = map(statistics.median, costs)
    assert large < 3 * small, (small, large)


@pytest.mark.slow
@linux
def test_memory_grows_with_the_front_only(tmp_path):
    """At this rate a million evaluations need 500 MiB: a copy of each generation would be seen."""
    first, *_, last = load.run(tmp_path, 36_000, points=4)
    assert last.evaluations - first.evaluations == 27_000
    assert last.solutions > first.solutions > 500
    assert last.resident_mib - first.resident_mib < 13.5


@pytest.mark.campaign
@linux
@pytest.mark.slow
def test_a_study_leaves_nothing_behind(tmp_path):
    assert load.study(tmp_path, 60) == load.Leftovers(60, (), (), ())
