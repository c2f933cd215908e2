import numpy as np
import pytest
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.core.problem import Problem
from pymoo.optimize import minimize
from pymoo.problems.multi import ZDT1

from mgeo import EvaluationError, compare
from mgeo.runs.algorithms import build_algorithm
from mgeo.studies.indicators import NoFeasibleSolutionError
from tests.mgeo.solved import solve


def sort_front(F):
    return F[np.lexsort(F.T[::-1])]


def test_solve_equals_minimize_of_pymoo():
    problem, algorithm = ZDT1(), NSGA2(pop_size=20)
    outcome = solve(problem, algorithm, 500, seed=3)
    expected = minimize(problem, algorithm, ("n_eval", 500), seed=3)
    assert np.array_equal(outcome.F, sort_front(expected.F))
    assert np.array_equal(problem.evaluate(outcome.X), outcome.F)
    assert (outcome.stop_reason, outcome.n_evaluations) == ("budget", 500)
    assert algorithm.problem is None  # A copy was run.


def test_callback_is_called_every_generation_and_can_stop_the_run():
    states = []

    def record_state(state):
        X, F = state.build_front()
        states.append((state.n_evaluations, len(F)))
        assert len(X) == len(F)
        if len(states) == 3:
            state.stop()

    outcome = solve(ZDT1(), NSGA2(pop_size=20), 500, seed=1, callback=record_state)
    assert [evaluations for evaluations, _ in states] == [20, 40, 60]
    assert (outcome.stop_reason, outcome.n_evaluations) == ("signal", 60)
    expected = minimize(ZDT1(), NSGA2(pop_size=20), ("n_eval", 60), seed=1)
    assert np.array_equal(outcome.F, sort_front(expected.F))
    assert len(outcome.F) == states[-1][1]


class InterruptedZDT1(ZDT1):
    def __init__(self, generation):
        super().__init__()
        self.n_left = generation

    def _evaluate(self, x, out, *args, **kwargs):
        if not self.n_left:
            raise KeyboardInterrupt
        self.n_left -= 1
        super()._evaluate(x, out, *args, **kwargs)


@pytest.mark.parametrize("generations", [0, 4])
def test_interrupt_within_generation_keeps_complete_generations(generations):
    problem = InterruptedZDT1(generations)
    outcome = solve(problem, NSGA2(pop_size=20), 500, seed=1)
    assert (outcome.stop_reason, outcome.n_evaluations) == ("signal", 20 * generations)
    if generations:
        expected = minimize(ZDT1(), NSGA2(pop_size=20), ("n_eval", 20 * generations), seed=1)
        assert np.array_equal(outcome.F, sort_front(expected.F))
    else:
        assert outcome.F.shape == (0, 2)


class FailingProblem(ZDT1):
    """Problem that fails if x2 exceeds a share of its range, optionally with a constraint."""

    def __init__(self, share, constrained=False):
        super().__init__(n_var=3)
        self.share, self.n_ieq_constr = share, int(constrained)

    def _evaluate(self, x, out, *args, **kwargs):
        super()._evaluate(x, out, *args, **kwargs)
        out["F"][x[:, 1] >= self.share] = np.nan
        if self.n_ieq_constr:
            out["G"] = 0.2 - x[:, :1]


class RaisingProblem(FailingProblem):
    """Problem that raises an error for the whole batch instead."""

    def _evaluate(self, x, out, *args, **kwargs):
        super()._evaluate(x, out, *args, **kwargs)
        if np.isnan(out["F"]).any():
            raise ValueError("no value here")


@pytest.mark.parametrize("kind", [FailingProblem, RaisingProblem])
@pytest.mark.parametrize("constrained", [False, True])
@pytest.mark.parametrize("name", ["nsga2", "mgeo-directed"])
def test_failed_candidates_are_not_in_fronts(name, constrained, kind):
    problem = kind(0.9, constrained)
    parameters = {} if name.startswith("mgeo") else {"population": 20}
    recorded_F = []
    record_front = lambda state: recorded_F.extend(state.build_front()[1])  # noqa: E731
    outcome = solve(problem, build_algorithm(name, parameters, problem), 400, 1, record_front)
    assert outcome.failures
    assert len(outcome.F)
    assert (outcome.X[:, 1] < 0.9).all()
    # For ZDT1 with three variables, f1 is at most 1 and f2 at most g = 1 + 9 / 2 * 2.
    assert (np.array(recorded_F) <= (1.0, 10.0)).all()


@pytest.mark.parametrize("name", ["nsga2", "mgeo-directed", "random"])
def test_run_whose_evaluations_all_failed_raises_error(name):
    problem = FailingProblem(-1.0)
    size = {"n_walkers": 8} if name.startswith("mgeo") else {"population": 24}
    algorithm = build_algorithm(name, size, problem)
    with pytest.raises(
        EvaluationError, match=r"all of the last \d+ candidates failed.*F\[0\] = nan"
    ):
        solve(problem, algorithm, 400, seed=1)
    with pytest.raises(NoFeasibleSolutionError, match="EvaluationError: all of the last"):
        compare(problem, {"it": algorithm}, 400, seeds=1)


def test_run_ends_without_new_designs():
    point = Problem(n_var=2, n_obj=2, xl=0.5, xu=0.5)
    point._evaluate = lambda X, out, *args, **kwargs: out.update(F=X)
    outcome = solve(point, NSGA2(pop_size=4), 100, seed=1)
    assert (outcome.stop_reason, outcome.X.tolist()) == ("exhausted", [[0.5, 0.5]])
