"""COMO-CMA-ES as a pymoo algorithm, against its authors' own loop and a front in closed form."""

import sys

import comocma
import numpy as np
import pytest
from pymoo.core.problem import Problem
from pymoo.optimize import minimize
from pymoo.problems import get_problem
from pymoo.problems.multi import BNH

from mgeo.runs.algorithms import build_algorithm
from mgeo.runs.como_cma_es import COMOCMAES
from tests.mgeo.runs.test_mo_cma_es import Ellipsoids


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


def test_kernels_that_stop_are_joined_by_new_ones_and_it_goes_on():
    algorithm = COMOCMAES(2)
    result = minimize(Ellipsoids(2), algorithm, ("n_eval", 3_000), seed=1)
    search = result.algorithm._search
    assert len(search) > 2
    assert search[0].stop()
    assert result.algorithm.evaluator.n_eval >= 3_000


def test_it_repeats_with_its_seed_alone():
    found = []
    for state in (1, 2):
        np.random.seed(state)  # noqa: NPY002
        found.append(minimize(Ellipsoids(), COMOCMAES(5), ("n_eval", 300), seed=7).F)
    assert np.array_equal(*found)


def test_it_stays_in_the_box_and_is_built_by_name():
    algorithm = build_algorithm("como-cma-es", {"population": 6}, Ellipsoids())
    assert algorithm.pop_size == 6
    seen = []
    minimize(
        Ellipsoids(), algorithm, ("n_eval", 600), seed=1,
        callback=lambda algorithm: seen.append(algorithm.pop.get("X")),
    )  # fmt: skip
    assert np.abs(np.concatenate(seen)).max() <= 5.0


def test_what_it_cannot_do_is_said(monkeypatch):
    with pytest.raises(ValueError, match="COMO-CMA-ES does not treat constraints"):
        minimize(BNH(), COMOCMAES(), ("n_gen", 2))
    with pytest.raises(ValueError, match="COMO-CMA-ES needs bounds"):
        minimize(Problem(n_var=2, n_obj=2), COMOCMAES(), ("n_gen", 2))
    with pytest.raises(ValueError, match=r"COMO-CMA-ES: 3 objective\(s\), expected 2"):
        minimize(get_problem("dtlz2"), COMOCMAES(), ("n_gen", 2))
    with pytest.raises(ValueError, match="COMO-CMA-ES: 1 variable, expected 2 or more"):
        minimize(Ellipsoids(1), COMOCMAES(), ("n_gen", 2))
    monkeypatch.setitem(sys.modules, "comocma", None)
    with pytest.raises(ValueError, match=r"needs the extra 'coco': pip install 'mgeo\[coco\]'"):
        build_algorithm("como-cma-es", {}, Ellipsoids())
