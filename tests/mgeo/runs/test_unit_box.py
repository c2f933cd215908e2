"""What MO-CMA-ES and COMO-CMA-ES have in common as pymoo algorithms."""

import sys

import numpy as np
import pytest
from pymoo.core.problem import Problem
from pymoo.optimize import minimize
from pymoo.problems.multi import BNH

from mgeo.runs.algorithms import build_algorithm
from mgeo.runs.pymoo_algorithms import COMOCMAES, MOCMAES

from .ellipsoids import Ellipsoids

both = pytest.mark.parametrize("cls", [MOCMAES, COMOCMAES])


@pytest.mark.parametrize(("cls", "pop_size"), [(MOCMAES, 10), (COMOCMAES, 5)])
def test_it_repeats_with_its_seed_alone(cls, pop_size):
    found = []
    for state in (1, 2):
        np.random.seed(state)  # noqa: NPY002
        found.append(minimize(Ellipsoids(), cls(pop_size), ("n_eval", 300), seed=7).F)
    assert np.array_equal(*found)


@pytest.mark.parametrize(("name", "population"), [("mo-cma-es", 12), ("como-cma-es", 6)])
def test_it_stays_in_the_box_and_is_built_by_name(name, population):
    algorithm = build_algorithm(name, {"population": population}, Ellipsoids())
    assert algorithm.pop_size == population
    seen = []
    minimize(
        Ellipsoids(), algorithm, ("n_eval", 600), seed=1,
        callback=lambda algorithm: seen.append(algorithm.pop.get("X")),
    )  # fmt: skip
    assert np.abs(np.concatenate(seen)).max() <= 5.0


@both
def test_what_it_cannot_do_is_said(cls):
    with pytest.raises(ValueError, match=f"{cls.title} does not treat constraints"):
        minimize(BNH(), cls(), ("n_gen", 2))
    with pytest.raises(ValueError, match=f"{cls.title} needs bounds"):
        minimize(Problem(n_var=2, n_obj=2), cls(), ("n_gen", 2))


@pytest.mark.parametrize(
    ("name", "module"), [("mo-cma-es", "deap.cma"), ("como-cma-es", "comocma")]
)
def test_without_its_package_what_to_install_is_said(monkeypatch, name, module):
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(ValueError, match=r"needs the extra 'coco': pip install 'mgeo\[coco\]'"):
        build_algorithm(name, {}, Ellipsoids())
