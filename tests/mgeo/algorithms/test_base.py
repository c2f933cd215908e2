"""What the loop gives to every variant."""

import numpy as np
import pytest
from pymoo.operators.sampling.lhs import LHS

from mgeo import MGEODirected, MGEOReal, MGEOStaged
from mgeo.testing import check_algorithm

from .problems import Galski, Rosenbrock
from .variants import VARIANTS, canonical, real, real2, var

ADAPTIVE = {"tau": "a-geo2", "restart": "archive", "patience": 1}


class Learning(MGEODirected):
    learning_after = 30


class AlwaysAttracted(MGEODirected):
    coupling, widths, return_to_best, migrate = (0.0, 1.0), (0.1, 0.1), 1.0, (0.0, 0.0)


@pytest.mark.cases(4)
@pytest.mark.parametrize(
    "algorithm",
    [
        real(n_walkers=3, **ADAPTIVE),
        canonical(n_walkers=3),
        MGEODirected(),
        MGEOStaged(stages=(0.0, 1.0), n_walkers=3, archive_size=9),
        *(variant(n_walkers=3, **ADAPTIVE) for variant in VARIANTS[1:]),
        real2(n_walkers=3),
        var(n_walkers=3),
        MGEOReal([0.5, 1.0, 0.1, 2.0], 1.0, 2, "range", archive_size=10),
        MGEOReal(0.5, n_walkers=4, perturbation="relative", sampling=LHS()),
        MGEODirected(n_walkers=3, extreme_weights=1.0, archive_size=10),
        MGEODirected(difference=(0.65, 0.65), momentum=(0.0, 0.0)),
        AlwaysAttracted(1.0, 6, 0.0, (1.0, 1.0), max_candidates=2),
        Learning(n_walkers=6),
    ],
    ids=lambda algorithm: type(algorithm).__name__,
)
def test_every_variant_passes_the_check_of_algorithms(algorithm):
    check_algorithm(algorithm)


@pytest.mark.parametrize(("variant", "n_groups", "n_candidates"), [(real2, 3, 13), (var, 3, 19)])
def test_one_candidate_of_each_group_is_accepted(variant, n_groups, n_candidates):
    algorithm = variant().setup(Rosenbrock(3), seed=1)
    for _ in range(20):
        before = algorithm.code.decode(algorithm.walkers.copy())
        candidates = algorithm.ask()
        X = candidates.get("X").reshape(4, n_candidates, 3)
        assert np.array_equal(X[:, 0], before)  # the walker itself comes first
        offers = X[:, 1:].reshape(4, n_groups, -1, 3)
        algorithm.evaluator.eval(algorithm.problem, candidates)
        algorithm.tell(infills=candidates)
        after = algorithm.code.decode(algorithm.walkers)
        for walker in range(4):
            for variable in range(3):
                assert after[walker, variable] in offers[walker, variable, :, variable]
                others = np.delete(offers[walker, variable], variable, axis=1)
                assert (others == np.delete(before[walker], variable)).all()


@pytest.mark.parametrize("variant", [real2, var])
def test_the_point_a_walker_reaches_is_evaluated_next(variant):
    algorithm = variant("a-geo2", 5).setup(Galski(4), seed=1)
    algorithm.next()
    stands = algorithm.code.decode(algorithm.walkers.copy())
    algorithm.next()
    X, F = (values.reshape(5, -1, values.shape[1]) for values in algorithm.pop.get("X", "F"))
    assert np.array_equal(X[:, 0], stands)
    assert np.array_equal(algorithm.state.current_fitness, np.column_stack([np.zeros(5), F[:, 0]]))
