"""Fronts in closed form, and the law of one-objective GEO_real against a plain-Python loop."""

import itertools

import numpy as np
import pytest
from pymoo.core.callback import Callback
from pymoo.optimize import minimize
from scipy.stats import ks_2samp

from mgeo import MGEOReal

from .. import naive
from .problems import Galski, Rosenbrock


def solved(case):
    return minimize(Galski(case), MGEOReal(0.5, 1.0, 20), ("n_gen", 300), seed=1)


def test_case_1_every_distinct_point_is_on_the_front():
    # f1' = -exp(-x) - 2.8 x exp(-x²) < 0 < f2' = exp(x) - 2.8 x exp(-x²) for every x
    algorithm = MGEOReal(0.5, 1.0, 20).setup(Galski(1), termination=("n_gen", 300), seed=1)
    visited = []
    while algorithm.has_next():
        infills = algorithm.ask()
        algorithm.evaluator.eval(algorithm.problem, infills)
        algorithm.tell(infills=infills)
        visited.append(infills.get("X"))
    visited = np.unique(np.concatenate(visited))
    assert len(visited) > 5000
    assert np.array_equal(np.sort(algorithm.result().X[:, 0]), visited)


def test_case_2_the_front_is_the_segment_from_0_to_2():
    # sqrt f1 + sqrt f2 = 2 for x in [0, 2], more elsewhere
    result = solved(2)
    assert np.sqrt(result.F).sum(axis=1) == pytest.approx(2.0, abs=0.01)
    assert np.diff(np.sort(result.X[:, 0]), prepend=0, append=2).max() < 0.02


def test_case_3_the_front_has_two_parts():
    x = np.sort(solved(3).X[:, 0])
    low, high = x[x < 3], x[x > 3]
    assert low.min() > 0.995
    assert low.max() < 2.005
    assert high.min() > 3.995
    assert high.max() < 5.005
    assert np.diff(low, prepend=1, append=2).max() < 0.03
    assert np.diff(high, prepend=4, append=5).max() < 0.03


def test_case_4_two_variables():
    # sqrt f1 + sqrt f2 is the way over x from one center to the other: least on the segment
    result = solved(4)
    way = np.sqrt(result.F).sum(axis=1)
    assert way.min() >= np.hypot(1.5, 3.5)
    assert way.max() < np.hypot(1.5, 3.5) + 0.1
    assert np.diff(np.sort(np.sqrt(result.F[:, 0])), prepend=0).max() < 0.1


class BestOfEachWalker(Callback):
    def __init__(self):
        super().__init__()
        self.best = np.inf

    def update(self, algorithm):
        f = algorithm.pop.get("F").reshape(algorithm.n_runs, -1)
        self.best = np.minimum(self.best, f.min(axis=1))


def rosenbrock(x):
    return sum(100 * (b - a * a) ** 2 + (1 - a) ** 2 for a, b in itertools.pairwise(x))


@pytest.mark.parametrize(
    ("n_var", "generations", "sigma", "tau"),
    [
        (2, 100, 0.5, 3.0),
        (2, 100, 1.0, 0.75),
        (5, 100, 0.5, 1.25),
        pytest.param(10, 200, 0.5, 3.0, marks=pytest.mark.slow),
    ],
)
def test_best_values_are_distributed_as_those_of_a_plain_loop(n_var, generations, sigma, tau):
    runs, seen = 100, BestOfEachWalker()
    algorithm = MGEOReal(sigma, tau, runs, "relative")
    minimize(Rosenbrock(n_var), algorithm, ("n_gen", generations), seed=1, callback=seen)
    rng = np.random.default_rng(5)
    bounds = [-2.048] * n_var, [2.048] * n_var
    plain = [
        naive.geo_minimum(rosenbrock, *bounds, generations, sigma, tau, rng) for _ in range(runs)
    ]
    assert ks_2samp(seen.best, plain).pvalue > 1e-3


@pytest.mark.parametrize("seed", range(3))
def test_rosenbrock_valley_is_found(seed):
    result = minimize(Rosenbrock(2), MGEOReal(0.1, n_runs=10), ("n_gen", 1000), seed=seed)
    assert result.F[0] < 2e-3
    assert pytest.approx([1.0, 1.0], abs=0.1) == result.X
