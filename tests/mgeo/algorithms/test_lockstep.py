"""Walkers in lockstep agree with a reference implementation of single walkers."""

import numpy as np
import pytest
from pymoo.core.callback import Callback
from pymoo.optimize import minimize
from pymoo.problems.multi import ZDT1

from mgeo import MGEOCanonical, MGEOReal, MGEOReal2, MGEOVar

from .. import naive
from ..naive_walk import Walk
from .problems import Galski, Mixture, Rosenbrock
from .variants import BITS, SIGMAS, VARIANTS, build_reference_moves


class Path(Callback):
    """Callback that records the walkers and their tau after each generation."""

    def __init__(self):
        super().__init__()
        self.points, self.taus = [], []

    def update(self, algorithm):
        self.points.append(algorithm.walkers.copy())
        self.taus.append(algorithm.state.taus.copy())


def run(problem, algorithm, generations, seed=7):
    path = Path()
    result = minimize(problem, algorithm, ("n_gen", generations), seed=seed, callback=path)
    return result, np.array(path.points), np.array(path.taus)


def assert_same_walks(problem, algorithm, generations, seed=7):
    result, path, taus = run(problem, algorithm, generations, seed)
    walks = [
        Walk(
            problem, build_reference_moves(algorithm, problem), algorithm.tau, seed, walker,
            isinstance(algorithm, MGEOReal2 | MGEOVar),
        )
        for walker in range(algorithm.n_walkers)
    ]  # fmt: skip
    for walker, walk in enumerate(walks):
        for _ in range(generations):
            walk.generation()
        assert np.array_equal(path[:, walker], walk.path)
        if isinstance(algorithm.tau, str):
            assert taus[:, walker] == pytest.approx(np.array(walk.taus), rel=1e-12)

    X, F, violation = (
        in_order_of_evaluation([getattr(walk, key) for walk in walks], generations)
        for key in ("X", "F", "violation")
    )
    rows = naive.archive_rows(F.tolist(), violation.tolist())
    assert np.array_equal(result.opt.get("X"), X[rows])
    assert np.array_equal(result.opt.get("F"), F[rows])


def in_order_of_evaluation(by_walker, generations):
    """Sort values by walker, (n_walkers, generations * candidates, ...), by order of evaluation."""
    values = np.array(by_walker)
    values = values.reshape(len(values), generations, -1, *values.shape[2:])
    return values.swapaxes(0, 1).reshape(-1, *values.shape[3:])


@pytest.mark.cases(2)
@pytest.mark.parametrize("problem", [Mixture(), Rosenbrock(3)], ids=["mixture", "rosenbrock"])
@pytest.mark.parametrize("variant", VARIANTS)
def test_lockstep_walkers_agree_with_sequential_walkers(variant, problem):
    assert_same_walks(problem, variant(n_walkers=2), 12)


@pytest.mark.cases(2)
@pytest.mark.parametrize("problem", [Mixture(), Rosenbrock(3)], ids=["mixture", "rosenbrock"])
@pytest.mark.parametrize("rule", ["a-geo1", "a-geo2"])
@pytest.mark.parametrize("variant", VARIANTS)
def test_lockstep_walkers_with_adaptive_tau_agree_with_sequential_walkers(variant, rule, problem):
    assert_same_walks(problem, variant(rule, 2), 12)


@pytest.mark.parametrize(
    ("problem", "algorithm"),
    [
        (Mixture(), MGEOReal(SIGMAS, 0.0, 4, "range")),
        (Mixture(), MGEOReal2(SIGMAS, 8.0, 3)),
        (Galski(1), MGEOReal(1.0, 2.0, 4, "relative")),
        (Mixture(), MGEOCanonical(1.0, 4, BITS)),
        (Mixture(), MGEOCanonical(1.0, 4, BITS, "gray")),
        (Mixture(), MGEOVar(1.0, 4, BITS)),
        (Mixture(), MGEOVar("a-geo2", 4, BITS, "gray")),
    ],
)
def test_lockstep_walkers_with_unequal_variables_agree_with_sequential_walkers(problem, algorithm):
    assert_same_walks(problem, algorithm, 12)


@pytest.mark.cases(2)
@pytest.mark.parametrize("tau", [2.0, "a-geo1"])
@pytest.mark.parametrize("variant", VARIANTS)
def test_walker_does_not_depend_on_number_of_walkers(variant, tau):
    problem = ZDT1(n_var=6)
    _, many, _ = run(problem, variant(tau, 9), 15)
    for n_walkers in (1, 4):
        _, few, _ = run(problem, variant(tau, n_walkers), 15)
        assert np.array_equal(few, many[:, :n_walkers])
