"""Initial points of the walkers of MGEOReal, and the shape of their steps."""

import numpy as np
import pytest
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


class ShapedSteps(MGEOReal):
    """MGEO_real whose standard deviations have a given shape."""

    def __init__(self, shape=(), **options):
        super().__init__(**options)
        self.shape = shape

    def compute_step_sigmas(self, sigma):
        return np.full(self.shape, 0.1)


@pytest.mark.parametrize("shape", [(6,), (8, 1, 6)])
def test_steps_are_equal_for_all_valid_shapes_of_equal_sigmas(shape):
    asked = [
        variant.setup(ZDT1(n_var=6), seed=1).ask().get("X")
        for variant in (MGEOReal(0.1, n_walkers=8), ShapedSteps(shape, n_walkers=8))
    ]
    np.testing.assert_array_equal(*asked)


def test_invalid_shape_of_step_sigmas_is_named():
    variant = ShapedSteps((8, 6), n_walkers=8).setup(ZDT1(n_var=6), seed=1)
    with pytest.raises(ValueError, match=r"shape \(8, 6\): expected .* to \(8, 1, 6\)"):
        variant.ask()
