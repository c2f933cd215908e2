"""MO-CMA-ES as a pymoo algorithm, against DEAP's own loop and a front in closed form."""

import deap.tools
import numpy as np
import pytest
from deap.cma import StrategyMultiObjective
from pymoo.optimize import minimize
from pymoo.problems.single import Sphere

from mgeo.runs.pymoo_algorithms import MOCMAES, Point, fitness_of, least_contributor

from .ellipsoids import Ellipsoids


def test_it_goes_as_deaps_own_loop(monkeypatch):
    problem, n, generations = Ellipsoids(), 8, 12
    algorithm = MOCMAES(n, 0.1)
    algorithm.setup(problem, termination=("n_gen", generations), seed=4)
    while algorithm.has_next():
        algorithm.next()

    rng = np.random.default_rng(4)
    theirs = [Point(x) for x in rng.random((n, 4))]
    monkeypatch.setattr(np.random, "randn", lambda *shape: rng.standard_normal(shape))

    def evaluate(points):
        X = np.array(points)
        outside = ((X - np.clip(X, 0, 1)) ** 2).sum(axis=1)
        F = problem.evaluate(-5 + 10 * np.clip(X, 0, 1))
        for point, f in zip(points, F + 1e-6 * outside[:, None], strict=True):
            point.fitness = fitness_of(f)

    evaluate(theirs)
    strategy = StrategyMultiObjective(theirs, 0.1, mu=n, lambda_=n)
    for _ in range(generations - 1):
        offspring = strategy.generate(Point)
        evaluate(offspring)
        strategy.update(offspring)
    assert np.array(algorithm._strategy.parents) == pytest.approx(np.array(strategy.parents))
    assert algorithm.pop.get("F") == pytest.approx(
        np.array([point.fitness.values for point in strategy.parents]), rel=1e-5
    )


def test_of_one_objective_there_is_no_front():
    with pytest.raises(ValueError, match="1 objective, expected 2 or more"):
        MOCMAES(4).setup(Sphere(), termination=("n_gen", 1), seed=1)


def test_the_least_contributor_is_that_of_deap():
    rng = np.random.default_rng(1)
    for _ in range(20):
        f = np.sort(rng.random(9))
        front = [Point([0.0]) for _ in f]
        for point, values in zip(
            front, np.column_stack([f, np.sort(rng.random(9))[::-1]]), strict=True
        ):
            point.fitness = fitness_of(values)
        ref = np.full(2, 2.0)
        assert least_contributor(front, ref) == deap.tools.hypervolume(front, ref=ref)


@pytest.mark.slow
def test_it_finds_the_front_of_rotated_ellipsoids():
    # of x'Ax and (x-1)'A(x-1) the front is the line between the minima: sqrt(f1) + sqrt(f2) = c
    problem = Ellipsoids()
    F = minimize(problem, MOCMAES(20), ("n_eval", 20_000), seed=1).F
    c = np.sqrt(problem.evaluate(np.ones((1, 4)))[0, 0])
    beyond = np.sqrt(F).sum(axis=1) / c - 1.0  # its ends stray sideways, where it costs them least
    assert beyond.min() > -1e-12
    assert np.median(beyond) < 2e-3
    assert beyond.max() < 0.02
    assert np.sqrt(F[:, 0]).max() > 0.85 * c
    assert np.sqrt(F[:, 0]).min() < 0.15 * c
