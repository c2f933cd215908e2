"""What the loop gives to every variant."""

import copy
import pickle

import numpy as np
import pytest

from mgeo.algorithms import ExtremalOptimization
from mgeo.testing import check_algorithm

from .problems import Galski, Rosenbrock
from .variants import VARIANTS, canonical, real2, var

ADAPTIVE = {"tau": "a-geo2", "restart": "archive", "patience": 1}


@pytest.mark.cases(2)
@pytest.mark.parametrize(
    ("variant", "options"),
    [(each, ADAPTIVE) for each in VARIANTS] + [(each, {}) for each in (real2, canonical, var)],
)
def test_it_is_a_good_pymoo_algorithm(variant, options):
    check_algorithm(variant(n_walkers=3, **options))


@pytest.mark.parametrize("variant", VARIANTS)
def test_copy_and_pickle_midway_continue_identically(variant):
    run = variant("a-geo2", restart="archive", patience=2)
    run.setup(Rosenbrock(3), termination=("n_gen", 10), seed=1)
    for _ in range(4):
        run.next()
    clones = [copy.deepcopy(run), pickle.loads(pickle.dumps(run))]
    F = run.run().F
    assert all(np.array_equal(clone.run().F, F) for clone in clones)


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


def test_of_a_single_string_one_bit_flips():
    algorithm = canonical().setup(Galski(4), seed=1)
    for _ in range(20):
        before = algorithm.walkers.copy()
        algorithm.next()
        assert np.isin(algorithm.walkers, (0.0, 1.0)).all()
        assert (algorithm.walkers != before).sum(axis=1).tolist() == [1, 1, 1, 1]


def test_high_pressure_takes_the_best_and_the_others_do_not():
    algorithm = canonical(60.0, 20).setup(Rosenbrock(2), seed=1)
    random = canonical(0.0, 20).setup(Rosenbrock(2), seed=1)
    shares = []
    for each in (algorithm, random):
        hits = []
        for _ in range(50):
            infills = each.ask()
            each.evaluator.eval(each.problem, infills)
            best = infills.get("F").reshape(20, 12).argmin(axis=1)
            X = infills.get("X").reshape(20, 12, 2)
            each.tell(infills=infills)
            stands = each.code.decode(each.walkers)
            hits.append((stands == X[np.arange(20), best]).all(axis=1))
        shares.append(np.mean(hits))
    assert shares[0] == 1.0
    assert shares[1] == pytest.approx(1 / 12, abs=4 * np.sqrt(1 / 12 / 1000))


@pytest.mark.parametrize("variant", [real2, var])
def test_the_point_a_walker_reaches_is_evaluated_next(variant):
    algorithm = variant("a-geo2", 5).setup(Galski(4), seed=1)
    algorithm.next()
    stands = algorithm.code.decode(algorithm.walkers.copy())
    algorithm.next()
    X, F = (values.reshape(5, -1, values.shape[1]) for values in algorithm.pop.get("X", "F"))
    assert np.array_equal(X[:, 0], stands)
    assert np.array_equal(algorithm.state.current_fitness, np.column_stack([np.zeros(5), F[:, 0]]))


def test_a_subclass_must_supply_its_part_of_the_loop():
    with pytest.raises(TypeError, match="abstract"):
        ExtremalOptimization(tau=1.0, n_walkers=1, archive_size=None, options={})
