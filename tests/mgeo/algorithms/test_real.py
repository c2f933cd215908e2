"""Initial points of the walkers of MGEOReal."""

import numpy as np
from pymoo.operators.sampling.lhs import LHS
from pymoo.problems.multi import ZDT1

from mgeo import MGEOReal

from .problems import Mixture


def test_walkers_start_uniformly_and_initial_points_are_not_evaluated():
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


def test_pymoo_sampling_places_walkers():
    problem = ZDT1(n_var=6)
    first, again = (MGEOReal(n_walkers=8, sampling=LHS()).setup(problem, seed=4) for _ in range(2))
    assert np.array_equal(first.walkers, again.walkers)
    cells = np.sort((first.walkers * 8).astype(int), axis=0)
    assert np.array_equal(cells, np.tile(np.arange(8)[:, None], (1, 6)))  # One per stratum.
