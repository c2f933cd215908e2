"""Algorithms by name: parameters, supported problems, and reproducible runs.

All tests are in one module, and so in one process, because numba compiles AGE-MOEA2 anew in each
process.
"""

import numpy as np
import pytest
from pymoo.core.problem import Problem
from pymoo.core.variable import Binary, Integer, Real
from pymoo.indicators.hv import HV
from pymoo.problems.many import DTLZ2
from pymoo.problems.multi import BNH, ZDT1
from pymoo.problems.single import Sphere

from mgeo.algorithms.variables import convert_numbers_to_designs
from mgeo.runs.algorithms import (
    build_algorithm,
    complete_parameters,
    compute_default_budget,
    set_up,
)
from mgeo.runs.registry import ALGORITHMS
from tests.mgeo.solved import solve

SMALL_PARAMETERS = {
    "mgeo-real": {"n_walkers": 4, "sigma": 0.1},
    "mgeo-real2": {"n_walkers": 1, "sigma": 0.2},
    "mgeo-canonical": {"n_walkers": 1, "bits": 5},
    "mgeo-var": {"n_walkers": 1, "bits": 5},
    "mgeo-directed": {"n_walkers": 4},
    "mgeo-staged": {"n_walkers": 4},
}
WITH_REFERENCE_DIRECTIONS = ("nsga3", "u-nsga3", "moead", "ctaea", "rvea")
# numba compiles AGE-MOEA2 in every process, which takes longer than all other tests.
SLOW = pytest.mark.slow
ALL_NAMES = [pytest.param(n, marks=SLOW) if n == "age-moea2" else n for n in ALGORITHMS]
HYPERVOLUME = HV(ref_point=np.array([1.1, 6.0]))


@pytest.mark.parametrize("name", ALL_NAMES)
def test_algorithm_improves_front_and_is_reproducible(name):
    problem = ZDT1(n_var=5)
    algorithm = build_algorithm(name, SMALL_PARAMETERS.get(name, {"population": 20}), problem)
    first = solve(problem, algorithm, 40, seed=1)
    longer = solve(problem, algorithm, 300, seed=1)
    repeated = solve(problem, algorithm, 300, seed=1)
    assert HYPERVOLUME(longer.F) > HYPERVOLUME(first.F)
    assert 300 <= longer.n_evaluations < 340
    assert np.array_equal(longer.X, repeated.X)
    assert np.array_equal(problem.evaluate(longer.X), longer.F)
    dominated = (longer.F[:, None] >= longer.F).all(axis=2) & (longer.F[:, None] > longer.F).any(
        axis=2
    )
    assert not dominated.any()


@pytest.mark.parametrize("name", WITH_REFERENCE_DIRECTIONS)
@pytest.mark.parametrize(("problem", "count"), [(ZDT1(), 50), (DTLZ2(), 45)])
def test_reference_directions_fill_the_population(name, problem, count):
    # Das and Dennis have C(p + m - 1, p) directions: 45 for p = 8 and 55 for p = 9, with m = 3.
    directions = build_algorithm(name, {"population": 50}, problem).ref_dirs
    assert directions.shape == (count, problem.n_obj)
    assert np.allclose(directions.sum(axis=1), 1)


def test_invalid_names_and_parameters_are_rejected():
    with pytest.raises(ValueError, match=r"'nsag2'.*did you mean 'nsga2'\?"):
        complete_parameters("nsag2", {})
    with pytest.raises(ValueError, match=r"'nsga2' has no parameter 'tau': expected population"):
        complete_parameters("nsga2", {"tau": 1})
    for population in (3, 4.5, True, "20"):
        with pytest.raises((ValueError, TypeError), match="expected an integer from 4 to 100,000"):
            build_algorithm("nsga2", {"population": population}, ZDT1())
    with pytest.raises(ValueError, match="tau = -1"):
        build_algorithm("mgeo-real", {"tau": -1}, ZDT1())


def test_unsupported_problems_are_rejected():
    with pytest.raises(ValueError, match="'moead' does not support the constraints"):
        build_algorithm("moead", {}, BNH())
    with pytest.raises(ValueError, match="'nsga2' needs bounds, which this problem does not have"):
        build_algorithm("nsga2", {}, Problem(n_var=2, n_obj=2))
    with pytest.raises(ValueError, match="needs 2 or more objectives"):
        build_algorithm("nsga3", {}, Sphere())
    with pytest.raises(ValueError, match="population = 4: expected >= 5"):
        build_algorithm("nsga3", {"population": 4}, DTLZ2(n_obj=5))


def test_default_budget_is_published_one_for_all_algorithms():
    problem = ZDT1(n_var=12)
    for name in ("mgeo-real", "nsga2"):
        assert compute_default_budget(build_algorithm(name, {}, problem), problem) == 59760
    single_walker = build_algorithm("mgeo-real", {"n_walkers": 1}, problem)
    assert compute_default_budget(single_walker, problem) == 60000


class DiscreteProblem(Problem):
    """Problem with integer or binary variables, which stores the evaluated designs."""

    def __init__(self, vtype):
        n_var, xu = (4, 9) if vtype is int else (12, 1)
        super().__init__(n_var=n_var, n_obj=2, xl=0, xu=xu, vtype=vtype)
        self.seen = []

    def _evaluate(self, X, out, *args, **kwargs):
        self.seen.append(X)
        rest = np.abs(X[:, 1:] - 0.34 * self.xu[1:]).sum(axis=1)
        out["F"] = np.column_stack([X[:, 0] + rest, np.square(self.xu[0] - X[:, 0]) + rest])


REAL_ONLY = ("mgeo-real", "mgeo-real2", "gde3", "nsde", "mopso-cd", "cmopso")


@pytest.mark.parametrize("vtype", [int, bool])
@pytest.mark.parametrize("name", ALL_NAMES)
def test_discrete_variables_are_supported_or_rejected(name, vtype):
    problem = DiscreteProblem(vtype)
    if name in REAL_ONLY or (name == "mgeo-var" and vtype is bool):
        message = "real variables" if name in REAL_ONLY else "1 bit"
        with pytest.raises(ValueError, match=message):
            set_up(
                problem, build_algorithm(name, SMALL_PARAMETERS.get(name, {}), problem), 100, seed=1
            )
        return
    algorithm = build_algorithm(name, SMALL_PARAMETERS.get(name, {"population": 20}), problem)
    outcome = solve(problem, algorithm, 200, seed=1)
    X = np.concatenate(problem.seen)
    assert {each.dtype.kind for each in problem.seen} == {"i" if vtype is int else "b"}
    assert (X >= 0).all()
    assert (problem.xu >= X).all()
    assert len(np.unique(X, axis=0)) > 10
    assert np.array_equal(
        outcome.F, problem.evaluate(convert_numbers_to_designs(problem, outcome.X))
    )


class MixedProblem(Problem):
    """Problem with an integer, a real and a binary variable, which are declared one by one."""

    def __init__(self):
        kinds = {"a": Integer(bounds=(0, 9)), "b": Real(bounds=(0, 1)), "c": Binary()}
        super().__init__(vars=kinds, n_obj=2)

    def _evaluate(self, X, out, *args, **kwargs):
        rows = [(x["a"] + x["b"], 9 - x["a"] + x["b"] + x["c"]) for x in X]
        out["F"] = np.array(rows, dtype=float)


@pytest.mark.parametrize("name", ["nsga2", "nsga3", "random", "mgeo-directed"])
def test_mixed_variables_are_supported(name):
    problem = MixedProblem()
    algorithm = build_algorithm(name, SMALL_PARAMETERS.get(name, {"population": 12}), problem)
    assert len(solve(problem, algorithm, 240, seed=1).F) >= 4


@pytest.mark.parametrize("name", ["gde3", "moead", "ctaea"])
def test_mixed_variables_are_rejected_by_algorithms_of_real_arrays(name):
    with pytest.raises(ValueError, match=f"^algorithm '{name}' takes arrays of real .* nsga2"):
        build_algorithm(name, {"population": 12}, MixedProblem())


class TiedProblem(ZDT1):
    """Problem whose constraint violations are 1, 2 or 3, so that many are equal."""

    def __init__(self):
        super().__init__(n_var=5)
        self.n_ieq_constr = 1

    def _evaluate(self, x, out, *args, **kwargs):
        super()._evaluate(x, out, *args, **kwargs)
        out["G"] = np.floor(4 * x[:, 1:2])


@pytest.mark.parametrize("name", ["mgeo-directed", "nsga3"])
def test_ties_are_broken_by_the_seeded_generator(name):
    problem = TiedProblem()
    algorithm = build_algorithm(name, SMALL_PARAMETERS.get(name, {"population": 20}), problem)
    first, repeated = (solve(problem, algorithm, 300, seed=1) for _ in range(2))
    assert np.array_equal(first.X, repeated.X)
