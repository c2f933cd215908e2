"""Instances of pymoo's algorithms: operators for the variables of a problem, and seeded ties."""

import numpy as np
import pytest
from pymoo.algorithms.moo.ctaea import CTAEA
from pymoo.algorithms.moo.gde3 import GDE3
from pymoo.algorithms.moo.mopso_cd import MOPSO_CD
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.algorithms.moo.nsga3 import NSGA3, comp_by_cv_then_random
from pymoo.algorithms.moo.unsga3 import comp_by_rank_and_ref_line_dist
from pymoo.algorithms.soo.nonconvex.cmaes import CMAES
from pymoo.algorithms.soo.nonconvex.pso import PSO
from pymoo.core.mixed import MixedVariableGA, MixedVariableMating
from pymoo.core.population import Population
from pymoo.core.problem import Problem
from pymoo.core.variable import Binary, Integer, Real
from pymoo.operators.crossover.ox import OrderCrossover
from pymoo.operators.crossover.sbx import SBX
from pymoo.operators.mutation.inversion import InversionMutation
from pymoo.operators.repair.rounding import RoundingRepair
from pymoo.operators.sampling.rnd import IntegerRandomSampling, PermutationRandomSampling
from pymoo.problems.multi import ZDT1

from mgeo import MGEODirected, compare
from mgeo.runs.operators import SeededComparison, fitted
from tests.mgeo.solved import solve

DIRECTIONS = np.column_stack([np.linspace(0, 1, 12), np.linspace(1, 0, 12)])


class Whole(Problem):
    def __init__(self, vtype=int):
        super().__init__(n_var=3, n_obj=2, xl=0, xu=9, vtype=vtype)

    def _evaluate(self, X, out, *args, **kwargs):
        assert X.dtype.kind == "i"
        out["F"] = np.column_stack([X[:, 0] + X[:, 1], 9 - X[:, 0] + X[:, 2]])


class Declared(Problem):
    def __init__(self):
        kinds = {"a": Integer(bounds=(0, 9)), "b": Real(bounds=(0, 1)), "c": Binary()}
        super().__init__(vars=kinds, n_obj=2)

    def _evaluate(self, X, out, *args, **kwargs):
        rows = [(x["a"] + x["b"], 9 - x["a"] + x["b"] + x["c"]) for x in X]
        out["F"] = np.array(rows, dtype=float)


class Tied(ZDT1):
    def __init__(self):
        super().__init__(n_var=4)
        self.n_ieq_constr = 1

    def _evaluate(self, x, out, *args, **kwargs):
        super()._evaluate(x, out, *args, **kwargs)
        out["G"] = np.floor(4 * x[:, 1:2])


def test_what_needs_nothing_is_left_as_it_is():
    for algorithm in (NSGA2(), GDE3(), MOPSO_CD(), MGEODirected()):
        assert fitted(algorithm, ZDT1()) is algorithm
    for problem in (Whole(), Declared(), Tied()):
        for algorithm in (NSGA2(), NSGA3(DIRECTIONS)):
            once = fitted(algorithm, problem)
            assert fitted(once, problem) is once


def test_integers_keep_the_parameters_of_crossover_and_mutation():
    given = NSGA2(pop_size=8, crossover=SBX(eta=4, prob=0.7))
    found = fitted(given, Whole())
    assert isinstance(found.mating.crossover.repair, RoundingRepair)
    assert isinstance(found.initialization.sampling, IntegerRandomSampling)
    assert (found.mating.crossover.eta.value, found.mating.crossover.prob.value) == (4, 0.7)
    assert given.mating.crossover.repair is None  # the one that was given is not changed
    assert NSGA2().mating.crossover.repair is None  # nor pymoo's own


def test_an_instance_takes_variables_declared_one_by_one():
    problem = Declared()
    compared = compare(problem, {"NSGA-II": NSGA2(pop_size=12)}, 240, seeds=[1])
    assert compared.runs["status"].tolist() == ["finished"]
    assert len(solve(problem, NSGA2(pop_size=12), 240, seed=1).F) >= 5


def test_operators_of_the_users_own_stay():
    mating = MixedVariableMating()
    own = MixedVariableGA(pop_size=8, mating=mating)
    assert fitted(own, Declared()) is own
    tour = NSGA2(
        sampling=PermutationRandomSampling(),
        crossover=OrderCrossover(),
        mutation=InversionMutation(),
    )
    assert fitted(tour, Whole()) is tour
    rounds = NSGA2(sampling=IntegerRandomSampling(), repair=RoundingRepair())
    assert fitted(rounds, Whole()) is rounds
    swarm = PSO(repair=RoundingRepair())
    assert fitted(swarm, Whole()) is swarm


@pytest.mark.parametrize("algorithm", [GDE3(), CMAES()])
@pytest.mark.parametrize("problem", [Whole(), Declared()])
def test_what_searches_reals_alone_is_refused(algorithm, problem):
    name = type(algorithm).__name__
    with pytest.raises(ValueError, match=f"^{name} takes arrays of real .* NSGA2"):
        solve(problem, algorithm, 40, seed=1)
    with pytest.raises(ValueError, match=r"^algorithms\['it'\] takes arrays of real"):
        compare(problem, {"it": algorithm}, 40, seeds=1)


@pytest.mark.parametrize("top", [0.0])
def test_a_run_ends_where_there_are_few_designs(top, monkeypatch):
    # C-TAEA begins with fewer than it has directions, if equal designs are left out at first
    monkeypatch.setattr("mgeo.runs.solve.IDLE_STEPS", 3)
    problem = Whole()
    problem.xu = np.full(3, top)
    for algorithm in (CTAEA(DIRECTIONS), NSGA2(pop_size=12)):
        found = solve(problem, algorithm, 60, seed=1)
        assert found.evaluations <= 12 + (top + 1) ** 3
        assert np.array_equal(found.X[:, 1:], np.zeros((len(found.X), 2)))


@pytest.mark.parametrize("pymoos", [comp_by_cv_then_random, comp_by_rank_and_ref_line_dist])
def test_where_nothing_ties_comparisons_are_pymoos(pymoos):
    population = Population.new(F=np.zeros((4, 2)), G=np.array([[0.0], [0.0], [1.0], [2.0]]))
    population.set("niche", 0, "rank", 0, "dist_to_niche", 0.5)
    pairs = np.array([(a, b) for a in range(4) for b in range(4) if a != b])
    draws = [np.random.default_rng(5) for _ in range(2)]
    expected = pymoos(population, pairs, random_state=draws[0])
    found = SeededComparison(pymoos)(population, pairs, random_state=draws[1])
    assert np.array_equal(found, expected)
