"""Adaptive tau and restarts of walkers."""

import math

import numpy as np
import pytest
from pymoo.optimize import minimize
from pymoo.problems.multi import ZDT1
from scipy.stats import kstest

from mgeo import MGEOCanonical, MGEOReal
from mgeo.algorithms import selection

from .problems import Fixed, Rosenbrock
from .variants import VARIANTS

FAILED, INFEASIBLE, FEASIBLE = (np.nan, 1.0), (9.0, -9.0), (5.0, 5.0)


def fitness(*rows, violation):
    return selection.compute_fitness(np.array(rows), np.array(violation))


def test_fitness_orders_feasible_infeasible_failed():
    value = fitness(FEASIBLE, (6.0, 4.0), INFEASIBLE, INFEASIBLE, FAILED, violation=[0, 0, 1, 2, 0])
    better = selection.is_better(value[:, None], value[None, :])
    worse_than = {  # in the first objective, in the second
        0: ({1, 2, 3, 4}, {2, 3, 4}),
        1: ({2, 3, 4}, {0, 2, 3, 4}),
        2: ({3, 4}, {3, 4}),
        3: ({4}, {4}),
        4: (set(), set()),
    }
    for row, per_objective in worse_than.items():
        for objective, expected in enumerate(per_objective):
            assert set(np.flatnonzero(better[row, :, objective])) == expected


def test_tau_is_reset_increased_or_unchanged():
    chance = np.array([0.0, 0.2, 0.3, 0.4])
    previous = np.array([0.5, 0.3, 0.3, 0.3])
    normal, uniform = np.array([1.0, 1, 1, 1]), np.array([0.5, 0.5, 0.5, 0.5])
    tau = selection.compute_next_tau(np.full(4, 2.0), chance, previous, normal, uniform, 16)
    assert tau == pytest.approx([0.5 * math.exp(0.25), 2 + 0.7 * 0.5, 2 + 0.8 * 0.5, 2.0])


def test_reset_tau_is_log_normal():
    rng = np.random.default_rng(0)
    n, zero = 5000, np.zeros(5000)
    tau = selection.compute_next_tau(
        np.full(n, 9.0), zero, zero, rng.standard_normal(n), rng.random(n), 9
    )
    assert kstest(np.log(2 * tau) * 3, "norm").pvalue > 1e-3


# ---- restarts ---------------------------------------------------------------------------------


@pytest.mark.parametrize("restart", ["random", "archive"])
@pytest.mark.parametrize("variant", VARIANTS)
def test_walker_without_progress_restarts(variant, restart):
    algorithm = variant("a-geo1", 5, restart=restart, patience=3).setup(Fixed([1.0, 2.0]), seed=1)
    for generation in range(1, 13):
        before = algorithm.encoding.decode(algorithm.walkers.copy())
        algorithm.next()
        after = algorithm.encoding.decode(algorithm.walkers)
        # The first generation of a new walker is progress; a restart follows three without any.
        assert algorithm.state.n_idle_generations.tolist() == [[0, 0, 1, 2][generation % 4]] * 5
        if generation % 4 == 0:
            front = algorithm.front.individuals.get("X")
            assert (algorithm.state.taus == 0.5).all()
            assert np.isinf(algorithm.state.incumbent_fitness[:, 0]).all()
            if restart == "archive":
                assert (after == front[0]).all()
            else:
                assert len(np.unique(after, axis=0)) == 5
        elif isinstance(algorithm, MGEOReal | MGEOCanonical):
            assert ((before != after).sum(axis=1) <= 1).all()


def test_progress_is_new_best_fitness_or_archived_candidate():
    algorithm = MGEOReal(0.3, 1.0, 6, restart="random", patience=10**6)
    algorithm.setup(ZDT1(n_var=3), seed=1)
    best, idle = np.full((6, 2), np.inf), np.zeros(6, dtype=int)
    for _ in range(80):
        infills = algorithm.ask()
        algorithm.evaluator.eval(algorithm.problem, infills)
        old = {id(entry) for entry in algorithm.front.individuals}
        algorithm.tell(infills=infills)
        new = {id(entry) for entry in algorithm.front.individuals} - old
        for walker in range(6):
            candidates = infills[3 * walker : 3 * walker + 3]
            F = candidates.get("F").min(axis=0)
            progress = (best[walker] > F).any() or any(id(each) in new for each in candidates)
            best[walker] = np.minimum(best[walker], F)
            idle[walker] = 0 if progress else idle[walker] + 1
        assert np.array_equal(algorithm.state.n_idle_generations, idle)
    assert idle.max() > 5


class Valleys(Rosenbrock):
    """Problem with a wide local minimum of 1 and a narrow global minimum of 0."""

    def _evaluate(self, X, out, *args, **kwargs):
        shallow = 1 + 10 * ((X + 1.0) ** 2).sum(axis=1)
        out["F"] = np.minimum(shallow, 30 * ((X - 1.8) ** 2).sum(axis=1))


@pytest.mark.slow
def test_walkers_with_high_tau_leave_local_optimum_only_by_restart():
    def share_stuck(**options):
        bests = np.full(30, np.inf)

        def watch(algorithm):
            np.minimum(bests, algorithm.pop.get("F").reshape(30, -1).min(axis=1), out=bests)

        algorithm = MGEOReal(0.1, 5.0, 30, **options)
        minimize(Valleys(2), algorithm, ("n_gen", 300), seed=1, callback=watch)
        return np.mean(bests >= 1)

    never = share_stuck()
    assert never > 0.4
    assert share_stuck(restart="random", patience=10) < 0.5 * never
    # The archive is a single point, in the global minimum.
    assert share_stuck(restart="archive", patience=10) == 0
