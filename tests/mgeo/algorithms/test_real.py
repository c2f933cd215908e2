"""Where the walkers of MGEOReal begin, and that it is a good pymoo algorithm."""

import numpy as np
import pytest
from pymoo.core.population import Population
from pymoo.operators.sampling.lhs import LHS
from pymoo.problems.multi import ZDT1

from mgeo import MGEOReal
from mgeo.testing import check_algorithm

from .problems import Mixture


def test_walkers_start_uniformly_and_their_starts_are_not_evaluated():
    problem = Mixture()
    algorithm = MGEOReal(n_walkers=500).setup(problem, seed=1)
    starts = algorithm.walkers.copy()
    assert np.all((starts >= problem.xl) & (starts <= problem.xu))
    share = (starts - problem.xl) / (problem.xu - problem.xl)
    assert np.allclose(share.mean(axis=0), 0.5, atol=4 / np.sqrt(12 * 500))
    candidates = algorithm.ask().get("X").reshape(500, 5, 5)
    changed = candidates != starts[:, None, :]
    assert not changed[:, ~np.eye(5, dtype=bool)].any()
    assert changed[:, np.eye(5, dtype=bool)].mean() > 0.99


@pytest.mark.parametrize("given", ["array", "list", "population"])
def test_given_starting_points_are_used(given):
    X = np.random.default_rng(0).random((3, 6))
    sampling = {"array": X, "list": X.tolist(), "population": Population.new("X", X)}[given]
    algorithm = MGEOReal(n_walkers=3, sampling=sampling).setup(ZDT1(n_var=6), seed=1)
    assert np.array_equal(algorithm.walkers, X)
    algorithm.next()
    assert np.array_equal(X, np.random.default_rng(0).random((3, 6)))


def test_pymoo_sampling_places_the_walkers():
    problem = ZDT1(n_var=6)
    first, again = (MGEOReal(n_walkers=8, sampling=LHS()).setup(problem, seed=4) for _ in range(2))
    assert np.array_equal(first.walkers, again.walkers)
    cells = np.sort((first.walkers * 8).astype(int), axis=0)
    assert np.array_equal(cells, np.tile(np.arange(8)[:, None], (1, 6)))  # one a stratum


@pytest.mark.parametrize(
    "algorithm",
    [
        MGEOReal(n_walkers=3),
        MGEOReal([0.5, 1.0, 0.1, 2.0], 1.0, 2, "range", archive_size=10),
        MGEOReal(0.5, n_walkers=4, perturbation="relative", sampling=LHS()),
    ],
    ids=["default", "limited", "sampled"],
)
def test_it_is_a_good_pymoo_algorithm(algorithm):
    check_algorithm(algorithm)
