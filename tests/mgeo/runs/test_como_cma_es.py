"""COMO-CMA-ES as a pymoo algorithm, against its authors' own loop and a front in closed form."""

import comocma
import numpy as np
import pytest
from pymoo.optimize import minimize
from pymoo.problems import get_problem

from mgeo.runs.pymoo_algorithms import COMOCMAES

from .ellipsoids import Ellipsoids


@pytest.fixture(autouse=True)
def elsewhere(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def test_it_goes_as_its_authors_own_loop():
    problem, steps, rng = Ellipsoids(), 60, np.random.default_rng(4)
    algorithm = COMOCMAES(5, 0.1)
    algorithm.setup(problem, termination=("n_gen", steps), seed=4)
    while algorithm.has_next():
        algorithm.next()

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
    assert not found.isarchive  # which changes nothing


@pytest.mark.slow
def test_it_finds_the_front_of_rotated_ellipsoids_and_writes_nothing(tmp_path):
    problem = Ellipsoids()
    F = minimize(problem, COMOCMAES(10), ("n_eval", 5_000), seed=1).F
    c = np.sqrt(problem.evaluate(np.ones((1, 4)))[0, 0])
    beyond = np.sqrt(F).sum(axis=1) / c - 1.0
    assert beyond.min() > -1e-12
    assert np.median(beyond) < 2e-3
    assert np.sqrt(F[:, 0]).max() > 0.95 * c
    assert np.sqrt(F[:, 0]).min() < 0.05 * c
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
def test_kernels_that_stop_are_joined_by_new_ones_and_it_goes_on():
    algorithm = COMOCMAES(2)
    result = minimize(Ellipsoids(2), algorithm, ("n_eval", 3_000), seed=1)
    search = result.algorithm._search
    assert len(search) > 2
    assert search[0].stop()
    assert result.algorithm.evaluator.n_eval >= 3_000


def test_of_how_many_objectives_and_variables_it_is_is_said():
    with pytest.raises(ValueError, match=r"COMO-CMA-ES: 3 objective\(s\), expected 2"):
        minimize(get_problem("dtlz2"), COMOCMAES(), ("n_gen", 2))
    with pytest.raises(ValueError, match="COMO-CMA-ES: 1 variable, expected 2 or more"):
        minimize(Ellipsoids(1), COMOCMAES(), ("n_gen", 2))
