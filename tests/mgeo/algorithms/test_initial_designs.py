"""Initial designs from users and problems, and budgets of less than one generation."""

import copy

import numpy as np
import pytest
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.core.evaluator import Evaluator
from pymoo.core.population import Population
from pymoo.core.termination import TerminateIfAny
from pymoo.optimize import minimize
from pymoo.problems.multi import BNH, ZDT1
from pymoo.termination.default import DefaultMultiObjectiveTermination
from pymoo.termination.max_eval import MaximumFunctionCallTermination
from pymoo.termination.max_gen import MaximumGenerationTermination

from mgeo import (
    MGEOCanonical,
    MGEODirected,
    MGEOReal,
    MGEOReal2,
    MGEOStaged,
    MGEOVar,
    SuggestedSampling,
)
from mgeo.algorithms import capture, restore

from .problems import Estimated, Typed

FAMILY = [
    MGEOReal(1e-3, n_walkers=5),
    MGEOReal2(1e-3, n_walkers=5),
    MGEOCanonical(n_walkers=5, bits=4),
    MGEOVar(n_walkers=5, bits=4),
    MGEODirected(n_walkers=5),
    MGEOStaged(n_walkers=5),
]
#: Three points of the front of ZDT1, which a search does not reach in two generations.
OPTIMA = np.column_stack([[0.123, 0.456, 0.789], np.zeros((3, 7))])


class Counting(ZDT1):
    """ZDT1 that records all evaluated points."""

    def __init__(self):
        super().__init__(n_var=8)
        self.seen = []

    def _evaluate(self, x, out, *args, **kwargs):
        self.seen += x.tolist()
        super()._evaluate(x, out, *args, **kwargs)


class Corner(BNH):
    """BNH with an upper bound of 2 on the second variable as a constraint."""

    def _evaluate(self, x, out, *args, **kwargs):
        super()._evaluate(x, out, *args, **kwargs)
        out["G"] = np.column_stack([x[:, 1] - 2.0, -x[:, 1]])


def of_family(function):
    return pytest.mark.parametrize("algorithm", FAMILY, ids=lambda each: type(each).__name__)(
        function
    )


def with_sampling(algorithm, sampling):
    given = copy.deepcopy(algorithm)
    given.sampling = sampling
    return given


@of_family
@pytest.mark.parametrize("given", ["array", "population"])
def test_initial_designs_are_evaluated_once_and_enter_result(algorithm, given):
    problem = Counting()
    sampling = OPTIMA if given == "array" else Population.new(X=OPTIMA)
    result = minimize(problem, with_sampling(algorithm, sampling), ("n_gen", 2), seed=1)
    assert problem.seen[:3] == OPTIMA.tolist()
    assert result.algorithm.evaluator.n_eval == len(problem.seen)
    found = result.X.tolist()
    assert all(point in found for point in OPTIMA.tolist())


@of_family
def test_evaluated_initial_designs_are_archived_before_first_generation(algorithm):
    problem, given = Counting(), Population.new(X=OPTIMA)
    Evaluator().eval(problem, given[:2])
    run = with_sampling(algorithm, given).setup(problem, termination=("n_gen", 2), seed=1)
    assert np.array_equal(run.front.F, given[:2].get("F"))
    problem.seen.clear()
    result = run.run()
    assert problem.seen[0] == OPTIMA[2].tolist()  # The only initial design to evaluate.
    others = len(problem.seen) - 1
    assert others == minimize(problem, algorithm, ("n_gen", 2), seed=1).algorithm.evaluator.n_eval
    found = result.X.tolist()
    assert all(point in found for point in OPTIMA.tolist())
    assert given[0].X is not run.front.individuals[0].X


def test_initial_designs_can_be_infeasible_or_dicts():
    given = Population.new(X=np.array([[1.0, 1.0], [0.0, 3.0]]))
    Evaluator().eval(Corner(), given)
    run = MGEOReal(n_walkers=3, sampling=given).setup(Corner(), seed=1)
    assert run.front.individuals.get("X").tolist() == [[1.0, 1.0]]
    run = MGEOReal(n_walkers=3, sampling=given[1:]).setup(Corner(), seed=1)
    assert run.front.violation == 1.0
    designs = np.array([{"a": 0.0, "b": -3, "c": False}], dtype=object)
    result = minimize(Typed(), MGEODirected(sampling=designs), ("n_gen", 1), seed=1)
    assert {"a": 0.0, "b": -3, "c": False} in result.X.tolist()


def test_failed_and_other_fidelity_initial_designs_are_evaluated_again():
    given = Population.new(X=OPTIMA)
    Evaluator().eval(Counting(), given)
    given[0].set("failed", True)
    run = MGEOReal(n_walkers=3, sampling=given).setup(Counting(), seed=1)
    assert len(run.front) == 2
    problem = Estimated()
    evaluated = Population.new(X=np.full((2, 4), [[0.2], [0.3]]))
    Evaluator().eval(problem, evaluated)
    staged = MGEOStaged(n_walkers=3, sampling=evaluated).setup(problem, seed=1)
    assert len(staged.front) == 0
    assert np.array_equal(staged.ask()[:2].get("X"), evaluated.get("X"))


def test_individuals_of_another_problem_are_rejected():
    given = Population.new(X=OPTIMA[:, :2])
    Evaluator().eval(BNH(), given)
    with pytest.raises(ValueError, match=r"sampling\[0\]\.G of shape \(2,\): expected \(0,\)"):
        MGEOReal(sampling=given).setup(ZDT1(n_var=2), seed=1)


@of_family
def test_run_restored_before_first_generation_has_same_initial_designs(algorithm):
    problem, given = Counting(), Population.new(X=OPTIMA)
    Evaluator().eval(problem, given[:1])
    run = with_sampling(algorithm, given).setup(problem, termination=("n_gen", 2), seed=1)
    restored = restore(capture(run), problem, algorithm)
    assert np.array_equal(restored.run().F, run.run().F)


@of_family
def test_first_generation_beyond_budget_is_truncated_with_warning(algorithm):
    problem = ZDT1(n_var=8)
    n_candidates = len(copy.deepcopy(algorithm).setup(problem, seed=1).ask())
    budget = n_candidates // 2
    with pytest.warns(
        RuntimeWarning, match=f"takes {n_candidates} evaluations.* budget of {budget}"
    ):
        result = minimize(problem, algorithm, ("n_eval", budget), seed=1)
    assert result.algorithm.evaluator.n_eval == budget
    assert result.algorithm.n_generations == 1
    first = minimize(problem, algorithm, ("n_gen", 1), seed=1).pop.get("X")
    assert np.array_equal(result.pop.get("X"), first[:budget])


@pytest.mark.parametrize(
    "termination",
    [DefaultMultiObjectiveTermination(n_max_evals=25), TerminateIfAny(
        MaximumFunctionCallTermination(25), MaximumGenerationTermination(9)
    )],
    ids=["default", "any"],
)  # fmt: skip
def test_budget_in_combined_termination_is_respected(termination):
    with pytest.warns(RuntimeWarning, match="takes 40 evaluations.* budget of 25"):
        result = minimize(ZDT1(n_var=8), MGEOReal(n_walkers=5), termination, seed=1)
    assert result.algorithm.evaluator.n_eval == 25


def test_small_budget_excess_and_initial_designs_are_evaluated():
    problem, algorithm = ZDT1(n_var=8), MGEOReal(n_walkers=5)  # 40 candidates per generation.
    result = minimize(problem, algorithm, ("n_eval", 37), seed=1)
    assert result.algorithm.evaluator.n_eval == 40
    with pytest.warns(RuntimeWarning, match="takes 43 evaluations"):
        result = minimize(problem, with_sampling(algorithm, OPTIMA), ("n_eval", 2), seed=1)
    assert result.algorithm.evaluator.n_eval == 3
    assert np.array_equal(result.X[:, 0], OPTIMA[:, 0])


class Suggesting(ZDT1):
    """ZDT1 that suggests points of its front, and records the first batch of evaluated points."""

    first = None

    def suggest_initial_designs(self, n, random_state):
        return np.column_stack([random_state.random(n), np.zeros((n, self.n_var - 1))])

    def _evaluate(self, x, out, *args, **kwargs):
        self.first = x.copy() if self.first is None else self.first
        super()._evaluate(x, out, *args, **kwargs)


@pytest.mark.parametrize(
    "algorithm",
    [
        MGEODirected(sampling=SuggestedSampling(5)),
        MGEOReal(sampling=SuggestedSampling(5)),
        MGEOStaged(sampling=SuggestedSampling(5)),
        NSGA2(pop_size=20, sampling=SuggestedSampling(5)),
    ],
)
def test_suggested_designs_are_evaluated_in_first_generation(algorithm):
    problem = Suggesting(n_var=6)
    result = minimize(problem, algorithm, ("n_gen", 1), seed=3)
    suggested = problem.first[:5]
    assert (suggested[:, 1:] == 0.0).all()
    assert len(np.unique(suggested[:, 0])) == 5
    assert np.isin(suggested[:, 0], result.X[:, 0]).all()
    assert len(result.pop) == len(problem.first) == result.algorithm.evaluator.n_eval


@pytest.mark.parametrize(
    ("n", "suggest", "message"),
    [
        (17, None, "initial_designs = 17: expected at most 16, the number of initial"),
        (2, lambda n, rng: np.full((2, 6), 3.0), r"sampling\[0, 0\] = 3.0: expected a number in"),
    ],
)
def test_invalid_suggested_designs_are_rejected(n, suggest, message):
    problem = Suggesting(n_var=6)
    if suggest is not None:
        problem.suggest_initial_designs = suggest
    with pytest.raises(ValueError, match=message):
        MGEODirected(sampling=SuggestedSampling(n)).setup(problem, seed=1)
