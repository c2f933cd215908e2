"""The tolerant evaluator: failing candidates do not affect other candidates."""

import os
import pickle
import warnings

import numpy as np
import pytest
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.algorithms.moo.nsga3 import NSGA3
from pymoo.algorithms.moo.spea2 import SPEA2
from pymoo.algorithms.soo.nonconvex.de import DE
from pymoo.algorithms.soo.nonconvex.ga import GA
from pymoo.algorithms.soo.nonconvex.pso import PSO
from pymoo.core.evaluator import Evaluator
from pymoo.core.population import Population
from pymoo.core.problem import ElementwiseProblem, LoopedElementwiseEvaluation, Problem
from pymoo.optimize import minimize
from pymoo.parallelization import JoblibParallelization
from pymoo.util.ref_dirs import get_reference_directions

from mgeo import EvaluationError, MGEOReal, TolerantEvaluator

pytestmark = pytest.mark.filterwarnings("ignore:a candidate failed:RuntimeWarning")


def is_failing(x):
    return 0.3 < x[0] < 0.4


def objectives(x):
    return np.array([x[0], (1.0 + x[1]) / (0.1 + x[0])])


class BatchProblem(Problem):
    """Vectorized problem that raises for a batch with a failing candidate.

    With `bad`, the objectives of failing candidates get this value instead.
    """

    def __init__(self, bad=None):
        self.bad, self.batches = bad, []
        super().__init__(n_var=2, n_obj=2, xl=0.0, xu=1.0)

    def _evaluate(self, X, out, *args, **kwargs):
        self.batches.append(len(X))
        failing = [is_failing(x) for x in X]
        if any(failing) and self.bad is None:
            raise ZeroDivisionError("failing candidate\nin batch")
        out["F"] = np.array([objectives(x) for x in X])
        out["F"][failing] = self.bad
        out["label"] = np.array([f"x = {x[0]:.3f}" for x in X])


class ElementProblem(ElementwiseProblem):
    """Elementwise problem that fails in a given way and counts its evaluations."""

    def __init__(self, kind="raise", **options):
        self.kind, self.calls = kind, 0
        super().__init__(n_var=2, n_obj=2, n_ieq_constr=1, xl=0.0, xu=1.0, **options)

    def _evaluate(self, x, out, *args, **kwargs):
        self.calls += 1
        out["F"], out["G"], out["n"] = objectives(x), [x[1] - 0.9], 1
        if is_failing(x):
            if self.kind == "raise":
                raise ValueError("failing candidate")
            if self.kind == "die":
                os._exit(1)
            if self.kind == "interrupt":
                raise KeyboardInterrupt
            out["G" if self.kind == "nan G" else "F"] = {
                "nan": [1.0, np.nan],
                "inf": [-np.inf, 1.0],
                "nan G": [np.nan],
            }[self.kind]


def candidates(n=60, seed=1):
    return Population.new(X=np.random.default_rng(seed).random((n, 2)))


def assert_only_failing_candidates_failed(population, evaluator):
    X, F = population.get("X", "F")
    failed = np.array([is_failing(x) for x in X])
    assert 0 < failed.sum() < len(X)
    assert [bool(mark) for mark in population.get("failed")] == failed.tolist()
    assert np.array_equal(F[~failed], [objectives(x) for x in X[~failed]])
    assert evaluator.n_failed == failed.sum() == sum(evaluator.causes.values())
    assert evaluator.n_eval == len(X)
    return failed


def test_batch_that_raises_is_bisected_until_failing_candidates_are_isolated():
    problem, evaluator, population = BatchProblem(), TolerantEvaluator(), candidates()
    evaluator.eval(problem, population)
    failed = assert_only_failing_candidates_failed(population, evaluator)
    assert evaluator.causes == {"ZeroDivisionError: failing candidate in batch": failed.sum()}
    assert problem.batches.count(1) >= failed.sum()
    assert sum(problem.batches) < 8 * len(population)
    labels = population.get("label")
    assert [label is None for label in labels] == failed.tolist()


@pytest.mark.parametrize("kind", ["raise", "nan", "inf", "nan G"])
def test_elementwise_problem_evaluates_each_candidate_once_despite_failures(kind):
    problem, evaluator, population = ElementProblem(kind), TolerantEvaluator(), candidates()
    evaluator.eval(problem, population)
    failed = assert_only_failing_candidates_failed(population, evaluator)
    assert problem.calls == len(population)
    cause = {"raise": "ValueError: failing candidate", "nan": "F[1] = nan", "inf": "F[0] = -inf",
             "nan G": "G[0] = nan"}[kind]  # fmt: skip
    assert evaluator.causes == {cause: failed.sum()}
    assert type(problem.elementwise_runner) is LoopedElementwiseEvaluation


def test_replacement_of_nan_values_does_not_hide_exception():
    population, evaluator = candidates(), TolerantEvaluator()
    evaluator.eval(ElementProblem(replace_nan_values_by=5.0), population)
    assert_only_failing_candidates_failed(population, evaluator)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["raise", "die"])
def test_failing_worker_process_affects_only_its_candidate(kind):
    problem = ElementProblem(kind, elementwise_runner=JoblibParallelization(n_jobs=2))
    population, evaluator = candidates(3), TolerantEvaluator()
    population[1].X = np.array([0.35, 0.5])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # joblib warns about a stopped worker.
        evaluator.eval(problem, population)
    assert_only_failing_candidates_failed(population, evaluator)
    if kind == "die":
        assert "TerminatedWorkerError" in next(iter(evaluator.causes))


class MethodRunner:
    """Runner that pickles a method separately from its object, as RayParallelization of pymoo."""

    def __call__(self, f, X):
        method = pickle.loads(pickle.dumps(f.__call__.__func__))
        return [method(pickle.loads(pickle.dumps(f)), x) for x in X]


def test_runner_that_pickles_methods_gives_serial_front():
    serial = solve(ElementProblem(), MGEOReal(0.2, n_walkers=5), 5)
    parallel = solve(
        ElementProblem(elementwise_runner=MethodRunner()), MGEOReal(0.2, n_walkers=5), 5
    )
    assert np.array_equal(parallel.F, serial.F)
    assert parallel.algorithm.evaluator.causes == serial.algorithm.evaluator.causes


class BrokenRunner:
    def __call__(self, f, X):
        raise ConnectionError("no scheduler")


@pytest.mark.parametrize("algorithm", [MGEOReal(n_walkers=5), NSGA2(20)], ids=["mgeo", "nsga2"])
def test_error_of_runner_ends_run_with_same_error(algorithm):
    evaluator = TolerantEvaluator()
    with pytest.raises(ConnectionError, match="no scheduler"):
        solve(ElementProblem(elementwise_runner=BrokenRunner()), algorithm, evaluator=evaluator)
    assert evaluator.n_failed == 0


def test_keyboard_interrupt_ends_evaluation():
    with pytest.raises(KeyboardInterrupt):
        TolerantEvaluator().eval(ElementProblem("interrupt"), candidates())


def solve(problem, algorithm, n_gen=40, **options):
    return minimize(problem, algorithm, ("n_gen", n_gen), **{"seed": 1, **options})


@pytest.mark.parametrize(
    ("problem", "equivalent"),
    [
        (BatchProblem(), BatchProblem(np.nan)),
        *((ElementProblem(kind), ElementProblem("nan")) for kind in ("raise", "inf")),
    ],
)
def test_search_does_not_depend_on_kind_of_failure(problem, equivalent):
    result = solve(problem, MGEOReal(0.2, n_walkers=5))
    expected = solve(equivalent, MGEOReal(0.2, n_walkers=5), evaluator=Evaluator())
    assert np.array_equal(result.X, expected.X)
    assert np.array_equal(result.F, expected.F)
    evaluator = result.algorithm.evaluator
    assert evaluator.n_eval == 40 * 10
    assert evaluator.n_failed == result.algorithm.front.n_rejected > 0


DIRECTIONS = get_reference_directions("das-dennis", 2, n_partitions=19)


@pytest.mark.parametrize(
    ("algorithm", "kind"), [(NSGA2(20), "raise"), (NSGA3(DIRECTIONS, 20), "inf")]
)
def test_pymoo_algorithms_find_front_although_candidates_fail(algorithm, kind):
    result = solve(ElementProblem(kind), algorithm, evaluator=TolerantEvaluator())
    assert result.algorithm.evaluator.n_failed > 0
    assert np.isfinite(result.F).all()
    assert not any(is_failing(x) for x in result.X)
    reference = solve(ElementProblem("raise"), NSGA2(20), evaluator=TolerantEvaluator())
    assert result.F[:, 0].min() == pytest.approx(reference.F[:, 0].min(), abs=0.05)


class FailingFromBatch(Problem):
    """Problem that raises after a given number of batches."""

    def __init__(self, n_successful=0):
        self.n_left = n_successful
        super().__init__(n_var=2, n_obj=2, xl=0.0, xu=1.0)

    def _evaluate(self, X, out, *args, **kwargs):
        self.n_left -= 1
        if self.n_left < 0:
            raise RuntimeError(f"no license {self.n_left}")
        out["F"] = X


class AlwaysFailing(Problem):
    """Problem whose objectives are always NaN."""

    def __init__(self, n_obj, n_ieq_constr):
        super().__init__(n_var=2, n_obj=n_obj, n_ieq_constr=n_ieq_constr, xl=0.0, xu=1.0)

    def _evaluate(self, X, out, *args, **kwargs):
        out["F"] = np.full((len(X), self.n_obj), np.nan)
        out["G"] = np.zeros((len(X), self.n_ieq_constr))


@pytest.mark.filterwarnings("ignore:invalid value encountered:RuntimeWarning")  # From SPEA2.
@pytest.mark.parametrize(
    ("algorithm", "n_obj"),
    [
        (MGEOReal(n_walkers=2), 2), (NSGA2(8), 2), (NSGA3(DIRECTIONS, 20), 2), (SPEA2(8), 2),
        (GA(8), 1), (DE(8), 1), (PSO(8), 1),
    ],
    ids=lambda value: type(value).__name__,
)  # fmt: skip
@pytest.mark.parametrize("n_constraints", [0, 1])
def test_run_without_successful_candidate_has_no_result(algorithm, n_obj, n_constraints):
    evaluator = TolerantEvaluator(patience=1000)
    result = solve(AlwaysFailing(n_obj, n_constraints), algorithm, 2, evaluator=evaluator)
    assert evaluator.n_failed == evaluator.n_eval > 0
    assert result.F is None
    assert result.X is None


@pytest.mark.parametrize("algorithm", [MGEOReal(n_walkers=2), NSGA2(4)], ids=["mgeo", "nsga2"])
@pytest.mark.parametrize("n_batches", [0, 3])
def test_consecutive_failures_stop_run_with_first_cause(algorithm, n_batches):
    evaluator = TolerantEvaluator(patience=10)
    with pytest.raises(EvaluationError) as raised:
        solve(FailingFromBatch(n_batches), algorithm, evaluator=evaluator)
    # The batch, its first half and its first candidate raise in turn.
    assert str(raised.value) == (
        "all of the last 12 candidates failed, the first with RuntimeError: no license -3"
    )
    assert "in _evaluate" in raised.value.__notes__[0]
    assert evaluator.n_eval == 4 * n_batches + 8


def test_only_first_exception_is_warned_about():
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        solve(BatchProblem(), MGEOReal(0.2, n_walkers=5))
        solve(ElementProblem("nan"), MGEOReal(0.2, n_walkers=5))
    assert [str(warning.message)[:32] for warning in caught] == ["a candidate failed with ZeroDivi"]
