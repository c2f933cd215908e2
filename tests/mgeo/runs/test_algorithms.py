"""Every algorithm by name: its parameters, what it treats, and what it finds.

All in one module, for one process: numba compiles AGE-MOEA2 anew in each.
"""

from types import SimpleNamespace

import numpy as np
import pytest
from pymoo.algorithms.moo import age2
from pymoo.core.problem import Problem
from pymoo.core.variable import Integer
from pymoo.indicators.hv import HV
from pymoo.problems.many import DTLZ2
from pymoo.problems.multi import BNH, ZDT1
from pymoo.problems.single import Sphere

from mgeo.algorithms.variables import designs_of
from mgeo.runs.algorithms import (
    ALGORITHMS,
    build_algorithm,
    complete_parameters,
    default_evaluations,
)
from mgeo.runs.limits import limits
from mgeo.runs.solve import solve

from ..algorithms.test_mixed import Rod as Strict

SMALL = {
    "mgeo-real": {"n_walkers": 4, "sigma": 0.1},
    "mgeo-real2": {"n_walkers": 1, "sigma": 0.2},
    "mgeo-canonical": {"n_walkers": 1, "bits": 5},
    "mgeo-var": {"n_walkers": 1, "bits": 5},
    "mgeo-directed": {"n_walkers": 4},
    "mgeo-staged": {"n_walkers": 4},
}
DIRECTED = ("nsga3", "u-nsga3", "moead", "ctaea", "rvea")
AREA = HV(ref_point=np.array([1.1, 6.0]))


@pytest.mark.parametrize(
    "name",
    # pymoo compiles it anew in every process
    [pytest.param(n, marks=pytest.mark.slow) if n == "age-moea2" else n for n in ALGORITHMS],
)
def test_every_algorithm_improves_a_front_and_repeats_itself(name):
    problem = ZDT1(n_var=5)
    algorithm = build_algorithm(name, SMALL.get(name, {"population": 20}), problem)
    first = solve(problem, algorithm, 20, seed=1)
    longer = solve(problem, algorithm, 600, seed=1)
    again = solve(problem, algorithm, 600, seed=1)
    assert AREA(longer.F) > AREA(first.F)
    assert 600 <= longer.evaluations < 640
    assert np.array_equal(longer.X, again.X)
    assert np.array_equal(problem.evaluate(longer.X), longer.F)
    worse = (longer.F[:, None] >= longer.F).all(axis=2) & (longer.F[:, None] > longer.F).any(axis=2)
    assert not worse.any()


@pytest.mark.parametrize("name", DIRECTED)
@pytest.mark.parametrize(("problem", "count"), [(ZDT1(), 50), (DTLZ2(), 45)])
def test_reference_directions_fill_the_population(name, problem, count):
    # Das and Dennis: C(p + m - 1, p) directions; 3 objectives: 45 for p = 8, 55 for p = 9
    directions = build_algorithm(name, {"population": 50}, problem).ref_dirs
    assert directions.shape == (count, problem.n_obj)
    assert np.allclose(directions.sum(axis=1), 1)


def test_names_parameters_and_values_are_checked():
    with pytest.raises(ValueError, match=r"'nsag2'.*did you mean 'nsga2'\?"):
        complete_parameters("nsag2", {})
    with pytest.raises(ValueError, match=r"'nsga2' has no parameter 'tau': expected population"):
        complete_parameters("nsga2", {"tau": 1})
    for population in (3, 4.5, True, "20"):
        with pytest.raises((ValueError, TypeError), match="expected an integer from 4 to 100,000"):
            build_algorithm("nsga2", {"population": population}, ZDT1())
    with pytest.raises(ValueError, match="tau = -1"):
        build_algorithm("mgeo-real", {"tau": -1}, ZDT1())


def test_problems_an_algorithm_cannot_treat_are_refused():
    with pytest.raises(ValueError, match="'moead' does not treat constraints"):
        build_algorithm("moead", {}, BNH())
    with pytest.raises(ValueError, match="needs 2 or more objectives"):
        build_algorithm("nsga3", {}, Sphere())
    with pytest.raises(ValueError, match="population = 4: expected >= 5"):
        build_algorithm("nsga3", {"population": 4}, DTLZ2(n_obj=5))


def test_parameters_are_completed():
    assert complete_parameters("mgeo-real", {"tau": 2.0}) == {
        "sigma": 1.0,
        "tau": 2.0,
        "n_walkers": 30,
        "perturbation": "absolute",
        "bounds": "clip",
        "restart": "never",
        "patience": 50,
    }


def test_the_default_budget_is_the_papers_and_the_same_for_all():
    problem = ZDT1(n_var=12)
    for name in ("mgeo-real", "nsga2"):
        assert default_evaluations(build_algorithm(name, {}, problem), problem) == 59760
    alone = build_algorithm("mgeo-real", {"n_walkers": 1}, problem)
    assert default_evaluations(alone, problem) == 60000


def test_an_algorithm_missing_from_pymoo_says_so(monkeypatch):
    monkeypatch.setattr("mgeo.runs.algorithms.import_module", lambda name: object())
    with pytest.raises(ValueError, match="'gde3' is not in the installed pymoo"):
        build_algorithm("gde3", {}, ZDT1())


def test_n_runs_of_the_papers_and_of_older_files_is_n_walkers():
    assert complete_parameters("mgeo-real", {"n_runs": 5})["n_walkers"] == 5
    with pytest.raises(TypeError, match="n_walkers = 4 and n_runs = 5: expected one of them"):
        complete_parameters("mgeo-real", {"n_runs": 5, "n_walkers": 4})


class Rod(Strict):
    """Without its checks of types: pymoo's operators give NumPy's numbers."""

    def _evaluate(self, X, out, *args, **kwargs):
        plain = {key: value.item() if hasattr(value, "item") else value for key, value in X.items()}
        super()._evaluate({**plain, "coated": bool(plain["coated"])}, out, *args, **kwargs)


class Free(Problem):
    """Without constraints."""

    def __init__(self):
        super().__init__(vars={"n": Integer(bounds=(0, 9))}, n_obj=2)


@pytest.fixture
def interpreted(monkeypatch):
    """AGE-MOEA2 as Python reads it: the same values, without 5 s of numba's time."""
    distances = age2.AGEMOEA2Survival.pairwise_distances.py_func
    monkeypatch.setattr(age2.AGEMOEA2Survival, "pairwise_distances", staticmethod(distances))
    monkeypatch.setattr(age2, "project_on_manifold", age2.project_on_manifold.py_func)
    monkeypatch.setattr(age2, "numba", SimpleNamespace(float64=float))


@pytest.mark.usefixtures("interpreted")
@pytest.mark.parametrize(
    "name",
    [
        "mgeo-directed",
        "mgeo-canonical",
        "nsga2",
        "nsga3",
        "u-nsga3",
        "spea2",
        "sms-emoa",
        "age-moea2",
    ],
)
def test_a_front_in_numbers_is_that_of_the_designs(name):
    problem = Rod()
    size = {} if name.startswith("mgeo") else {"population": 20}
    outcome = solve(problem, build_algorithm(name, size, problem), 300, seed=1)
    assert outcome.X.shape == (len(outcome.F), 5)
    designs = designs_of(problem, outcome.X)
    assert {type(design["material"]) for design in designs} == {str}
    F, G = problem.evaluate(designs, return_values_of=["F", "G"])
    assert np.array_equal(F, outcome.F)
    told = [limit.margin for each in limits(problem, outcome.X) for limit in each]
    assert told == (-G[:, 0]).tolist()


@pytest.mark.parametrize("name", ["random", "gde3", "moead", "cmopso"])
def test_what_takes_arrays_alone_is_refused(name):
    with pytest.raises(ValueError, match=f"algorithm '{name}' .*one of mgeo-real, .*, nsga2, "):
        build_algorithm(name, {"population": 20}, Free())
