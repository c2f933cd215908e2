"""`docs/studies/cma_es.py` against the loops of DEAP and of comocma, and against a known front."""

import numpy as np
import pytest
from pymoo.core.problem import Problem
from pymoo.optimize import minimize
from pymoo.problems import get_problem

from docs.studies.cma_es import COMOCMAES, MOCMAES, Point, minimized

ROTATION = np.linalg.qr(np.random.default_rng(3).standard_normal((4, 4)))[0]
A = ROTATION @ np.diag(10.0 ** np.linspace(0, 2, 4)) @ ROTATION.T


class Ellipsoids(Problem):
    """x'Ax and (x-1)'A(x-1): the front is the line between the minima."""

    def __init__(self):
        super().__init__(n_var=4, n_obj=2, xl=-5.0, xu=5.0)

    def _evaluate(self, X, out, *args, **kwargs):
        out["F"] = np.column_stack([((X - c) @ A * (X - c)).sum(axis=1) for c in (0.0, 1.0)])


def run(algorithm, generations):
    algorithm.setup(Ellipsoids(), termination=("n_gen", generations), seed=4)
    while algorithm.has_next():
        algorithm.next()
    return algorithm


def test_mo_cma_es_makes_the_steps_of_deaps_own_loop(monkeypatch):
    strategy_class = pytest.importorskip("deap.cma").StrategyMultiObjective
    n, generations, problem = 8, 12, Ellipsoids()
    algorithm = run(MOCMAES(n, 0.1), generations)
    rng = np.random.default_rng(4)
    theirs = [Point(x) for x in rng.random((n, 4))]
    monkeypatch.setattr(np.random, "randn", lambda *shape: rng.standard_normal(shape))

    def evaluate(points):
        X = np.array(points)
        outside = ((X - np.clip(X, 0, 1)) ** 2).sum(axis=1)
        F = problem.evaluate(-5 + 10 * np.clip(X, 0, 1))
        for point, f in zip(points, F + 1e-6 * outside[:, None], strict=True):
            point.fitness = minimized(f)

    evaluate(theirs)
    strategy = strategy_class(theirs, 0.1, mu=n, lambda_=n)
    for _ in range(generations - 1):
        offspring = strategy.generate(Point)
        evaluate(offspring)
        strategy.update(offspring)
    assert np.array(algorithm._strategy.parents) == pytest.approx(np.array(strategy.parents))


def test_como_cma_es_makes_the_steps_of_its_authors_loop(tmp_path, monkeypatch):
    comocma = pytest.importorskip("comocma")
    monkeypatch.chdir(tmp_path)
    problem, steps, rng = Ellipsoids(), 60, np.random.default_rng(4)
    algorithm = run(COMOCMAES(5, 0.1), steps)
    options = {
        "bounds": [0, 1], "seed": np.nan, "verbose": -9, "verb_log": 0, "tolx": 1e-6,
        "randn": lambda *shape: rng.standard_normal(shape),
    }  # fmt: skip
    kernels = comocma.get_cmas(rng.random((5, 4)).tolist(), 0.1, options)
    theirs = comocma.Sofomore(
        kernels, None, {"update_order": lambda _: rng.random(), "verb_log": 0}
    )
    for _ in range(steps):
        points = theirs.ask()
        F = problem.evaluate(-5 + 10 * np.array(points))
        if theirs.reference_point is None:
            theirs.reference_point = F[:5].max(axis=0).tolist()
        theirs.tell(points, F.tolist())
    found = algorithm._search
    assert [k.incumbent.tolist() for k in found] == [k.incumbent.tolist() for k in theirs]
    assert found.countevals == theirs.countevals == algorithm.evaluator.n_eval
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
@pytest.mark.parametrize(
    ("algorithm", "n_eval", "reached"), [(MOCMAES(20), 20_000, 0.85), (COMOCMAES(10), 5_000, 0.95)]
)
def test_both_find_the_front_of_rotated_ellipsoids(
    algorithm, n_eval, reached, tmp_path, monkeypatch
):
    """On the front, sqrt(f1) + sqrt(f2) is the distance of the minima in the metric of A."""
    monkeypatch.chdir(tmp_path)
    F = minimize(Ellipsoids(), algorithm, ("n_eval", n_eval), seed=1).F
    c = np.sqrt(np.ones(4) @ A @ np.ones(4))
    excess = np.sqrt(F).sum(axis=1) / c - 1.0
    assert excess.min() > -1e-12
    assert np.median(excess) < 2e-3
    assert np.sqrt(F[:, 0]).max() > reached * c
    assert np.sqrt(F[:, 0]).min() < (1 - reached) * c


@pytest.mark.parametrize("cls", [MOCMAES, COMOCMAES])
def test_constraints_are_refused(cls):
    with pytest.raises(ValueError, match="expected a problem of two objectives with bounds and"):
        minimize(get_problem("bnh"), cls(), ("n_gen", 2))
