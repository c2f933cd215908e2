"""MO-CMA-ES as a pymoo algorithm, against DEAP's own loop and a front in closed form."""

import sys

import deap.tools
import numpy as np
import pytest
from deap.cma import StrategyMultiObjective
from pymoo.core.problem import Problem
from pymoo.optimize import minimize
from pymoo.problems.multi import BNH

from mgeo.runs.algorithms import build_algorithm
from mgeo.runs.mo_cma_es import MOCMAES, _fitness, _least_contributor, _Point


class Ellipsoids(Problem):
    """Two rotated ellipsoids of condition 100 with their minima apart, within wide bounds."""

    def __init__(self, n_var=4):
        super().__init__(n_var=n_var, n_obj=2, xl=-5.0, xu=5.0)
        turned, _ = np.linalg.qr(np.random.default_rng(3).standard_normal((n_var, n_var)))
        self.metric = turned * 10.0 ** np.linspace(0, 2, n_var) @ turned.T
        self.ends = np.zeros(n_var), np.ones(n_var)

    def _evaluate(self, X, out, *args, **kwargs):
        steps = [X - end for end in self.ends]
        out["F"] = np.column_stack([np.einsum("ni,ij,nj->n", s, self.metric, s) for s in steps])


def test_it_goes_as_deaps_own_loop(monkeypatch):
    problem, n, generations = Ellipsoids(), 8, 12
    algorithm = MOCMAES(n, 0.1)
    algorithm.setup(problem, termination=("n_gen", generations), seed=4)
    while algorithm.has_next():
        algorithm.next()

    rng = np.random.default_rng(4)
    theirs = [_Point(x) for x in rng.random((n, 4))]
    monkeypatch.setattr(np.random, "randn", lambda *shape: rng.standard_normal(shape))

    def evaluate(points):
        X = np.array(points)
        outside = ((X - np.clip(X, 0, 1)) ** 2).sum(axis=1)
        F = problem.evaluate(-5 + 10 * np.clip(X, 0, 1))
        for point, f in zip(points, F + 1e-6 * outside[:, None], strict=True):
            point.fitness = _fitness(f)

    evaluate(theirs)
    strategy = StrategyMultiObjective(theirs, 0.1, mu=n, lambda_=n)
    for _ in range(generations - 1):
        offspring = strategy.generate(_Point)
        evaluate(offspring)
        strategy.update(offspring)
    assert np.array(algorithm._strategy.parents) == pytest.approx(np.array(strategy.parents))
    assert algorithm.pop.get("F") == pytest.approx(
        np.array([point.fitness.values for point in strategy.parents]), rel=1e-5
    )


def test_the_least_contributor_is_that_of_deap():
    rng = np.random.default_rng(1)
    for _ in range(20):
        f = np.sort(rng.random(9))
        front = [_Point([0.0]) for _ in f]
        for point, values in zip(
            front, np.column_stack([f, np.sort(rng.random(9))[::-1]]), strict=True
        ):
            point.fitness = _fitness(values)
        ref = np.full(2, 2.0)
        assert _least_contributor(front, ref) == deap.tools.hypervolume(front, ref=ref)


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


def test_it_repeats_with_its_seed_alone():
    found = []
    for state in (1, 2):
        np.random.seed(state)  # noqa: NPY002
        found.append(minimize(Ellipsoids(), MOCMAES(10), ("n_eval", 300), seed=7).F)
    assert np.array_equal(*found)


def test_it_stays_in_the_box_and_is_built_by_name():
    algorithm = build_algorithm("mo-cma-es", {"population": 12}, Ellipsoids())
    assert algorithm.pop_size == 12
    seen = []
    minimize(
        Ellipsoids(), algorithm, ("n_eval", 600), seed=1,
        callback=lambda algorithm: seen.append(algorithm.pop.get("X")),
    )  # fmt: skip
    assert np.abs(np.concatenate(seen)).max() <= 5.0


def test_what_it_cannot_do_is_said(monkeypatch):
    with pytest.raises(ValueError, match="does not treat constraints"):
        minimize(BNH(), MOCMAES(), ("n_gen", 2))
    with pytest.raises(ValueError, match="needs bounds"):
        minimize(Problem(n_var=2, n_obj=2), MOCMAES(), ("n_gen", 2))
    monkeypatch.setitem(sys.modules, "deap.cma", None)
    with pytest.raises(ValueError, match=r"needs the extra 'coco': pip install 'mgeo\[coco\]'"):
        build_algorithm("mo-cma-es", {}, Ellipsoids())
