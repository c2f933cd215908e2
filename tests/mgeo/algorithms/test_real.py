"""The lockstep loop against one walker after the other, step for step."""

import numpy as np
import pytest
from pymoo.core.callback import Callback
from pymoo.core.population import Population
from pymoo.operators.sampling.lhs import LHS
from pymoo.optimize import minimize
from pymoo.problems.multi import ZDT1

from mgeo import MGEOReal
from mgeo.testing import check_algorithm

from .. import naive
from .problems import Galski, Mixture, Rosenbrock


class Path(Callback):
    """Where the walkers stand after each generation."""

    def __init__(self):
        super().__init__()
        self.points = []

    def update(self, algorithm):
        self.points.append(algorithm.walkers.copy())


def run(problem, algorithm, generations, seed=7):
    path = Path()
    result = minimize(problem, algorithm, ("n_gen", generations), seed=seed, callback=path)
    return result, np.array(path.points)


CASES = [
    (Mixture(), 0.7, 3.0, "absolute"),
    (Mixture(), 1.0, 1.2, "relative"),
    (Mixture(), (0.1, 0.2, 0.3, 0.4, 0.5), 0.0, "range"),
    (Rosenbrock(3), 0.5, 1.0, "absolute"),
    (Galski(1), 1.0, 2.0, "relative"),
]


@pytest.mark.parametrize(("problem", "sigma", "tau", "perturbation"), CASES)
def test_walkers_in_lockstep_go_as_one_after_the_other(problem, sigma, tau, perturbation):
    n_runs, generations = 4, 40
    algorithm = MGEOReal(sigma, tau, n_runs, perturbation)
    result, path = run(problem, algorithm, generations)
    walks = [
        naive.walk(problem, 7, walker, generations, sigma, tau, perturbation)
        for walker in range(n_runs)
    ]
    for walker, (points, *_) in enumerate(walks):
        assert np.array_equal(path[:, walker], points)

    X, F, violation = (
        in_order_of_evaluation([walk[k] for walk in walks], generations) for k in (1, 2, 3)
    )
    rows = naive.archive_rows(F.tolist(), violation.tolist())
    assert np.array_equal(result.opt.get("X"), X[rows])
    assert np.array_equal(result.opt.get("F"), F[rows])


def in_order_of_evaluation(by_walker, generations):
    """(n_runs, generations * n_var, ...) to rows as the lockstep evaluates them."""
    values = np.array(by_walker)
    values = values.reshape(len(values), generations, -1, *values.shape[2:])
    return values.swapaxes(0, 1).reshape(-1, *values.shape[3:])


def test_a_walk_does_not_depend_on_how_many_go_beside_it():
    problem = ZDT1(n_var=6)
    _, many = run(problem, MGEOReal(0.3, n_runs=9), 25)
    for n_runs in (1, 4):
        _, few = run(problem, MGEOReal(0.3, n_runs=n_runs), 25)
        assert np.array_equal(few, many[:, :n_runs])


def test_walkers_start_uniformly_and_their_starts_are_not_evaluated():
    problem = Mixture()
    algorithm = MGEOReal(n_runs=500).setup(problem, seed=1)
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
    algorithm = MGEOReal(n_runs=3, sampling=sampling).setup(ZDT1(n_var=6), seed=1)
    assert np.array_equal(algorithm.walkers, X)
    algorithm.next()
    assert np.array_equal(X, np.random.default_rng(0).random((3, 6)))


def test_pymoo_sampling_places_the_walkers():
    problem = ZDT1(n_var=6)
    first, again = (MGEOReal(n_runs=8, sampling=LHS()).setup(problem, seed=4) for _ in range(2))
    assert np.array_equal(first.walkers, again.walkers)
    cells = np.sort((first.walkers * 8).astype(int), axis=0)
    assert np.array_equal(cells, np.tile(np.arange(8)[:, None], (1, 6)))  # one a stratum


@pytest.mark.parametrize(
    "algorithm",
    [
        MGEOReal(n_runs=3),
        MGEOReal([0.5, 1.0, 0.1, 2.0], 1.0, 2, "range", archive_size=10),
        MGEOReal(0.5, n_runs=4, perturbation="relative", sampling=LHS()),
    ],
    ids=["default", "limited", "sampled"],
)
def test_it_is_a_good_pymoo_algorithm(algorithm):
    check_algorithm(algorithm)
