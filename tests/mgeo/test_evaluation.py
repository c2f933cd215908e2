"""Candidates that fail cost themselves only, whatever way they fail."""

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


def culprit(x):
    return 0.3 < x[0] < 0.4


def objectives(x):
    return np.array([x[0], (1.0 + x[1]) / (0.1 + x[0])])


class Batch(Problem):
    """A whole batch raises if one of it is a culprit; or culprits get a bad value."""

    def __init__(self, bad=None):
        self.bad, self.batches = bad, []
        super().__init__(n_var=2, n_obj=2, xl=0.0, xu=1.0)

    def _evaluate(self, X, out, *args, **kwargs):
        self.batches.append(len(X))
        culprits = [culprit(x) for x in X]
        if any(culprits) and self.bad is None:
            raise ZeroDivisionError("culprit\nin it")
        out["F"] = np.array([objectives(x) for x in X])
        out["F"][culprits] = self.bad
        out["label"] = np.array([f"x = {x[0]:.3f}" for x in X])


class Element(ElementwiseProblem):
    """Fails for culprits in the way it is told to; counts every call."""

    def __init__(self, way="raise", **options):
        self.way, self.calls = way, 0
        super().__init__(n_var=2, n_obj=2, n_ieq_constr=1, xl=0.0, xu=1.0, **options)

    def _evaluate(self, x, out, *args, **kwargs):
        self.calls += 1
        out["F"], out["G"], out["n"] = objectives(x), [x[1] - 0.9], 1
        if culprit(x):
            if self.way == "raise":
                raise ValueError("culprit")
            if self.way == "die":
                os._exit(1)
            if self.way == "interrupt":
                raise KeyboardInterrupt
            out["G" if self.way == "nan G" else "F"] = {
                "nan": [1.0, np.nan],
                "inf": [-np.inf, 1.0],
                "nan G": [np.nan],
            }[self.way]


def candidates(n=60, seed=1):
    return Population.new(X=np.random.default_rng(seed).random((n, 2)))


def assert_only_culprits_failed(population, evaluator):
    X, F = population.get("X", "F")
    failed = np.array([culprit(x) for x in X])
    assert 0 < failed.sum() < len(X)
    assert [bool(mark) for mark in population.get("failed")] == failed.tolist()
    assert np.array_equal(F[~failed], [objectives(x) for x in X[~failed]])
    assert evaluator.n_failed == failed.sum() == sum(evaluator.causes.values())
    assert evaluator.n_eval == len(X)
    return failed


def test_a_batch_that_raises_is_halved_until_the_culprits_are_alone():
    problem, evaluator, population = Batch(), TolerantEvaluator(), candidates()
    evaluator.eval(problem, population)
    failed = assert_only_culprits_failed(population, evaluator)
    assert evaluator.causes == {"ZeroDivisionError: culprit in it": failed.sum()}
    assert problem.batches.count(1) >= failed.sum()
    assert sum(problem.batches) < 8 * len(population)
    labels = population.get("label")
    assert [label is None for label in labels] == failed.tolist()


@pytest.mark.parametrize("way", ["raise", "nan", "inf", "nan G"])
def test_an_element_that_fails_is_not_evaluated_again_nor_are_others(way):
    problem, evaluator, population = Element(way), TolerantEvaluator(), candidates()
    evaluator.eval(problem, population)
    failed = assert_only_culprits_failed(population, evaluator)
    assert problem.calls == len(population)
    cause = {"raise": "ValueError: culprit", "nan": "F[1] = nan", "inf": "F[0] = -inf",
             "nan G": "G[0] = nan"}[way]  # fmt: skip
    assert evaluator.causes == {cause: failed.sum()}
    assert type(problem.elementwise_runner) is LoopedElementwiseEvaluation


def test_a_value_that_replaces_nan_does_not_hide_an_exception():
    population, evaluator = candidates(), TolerantEvaluator()
    evaluator.eval(Element(replace_nan_values_by=5.0), population)
    assert_only_culprits_failed(population, evaluator)


@pytest.mark.slow
@pytest.mark.parametrize("way", ["raise", "die"])
def test_candidates_fail_alone_where_a_worker_process_raises_or_dies(way):
    problem = Element(way, elementwise_runner=JoblibParallelization(n_jobs=2))
    population, evaluator = candidates(3), TolerantEvaluator()
    population[1].X = np.array([0.35, 0.5])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # joblib on a worker that stopped
        evaluator.eval(problem, population)
    assert_only_culprits_failed(population, evaluator)
    if way == "die":
        assert "TerminatedWorkerError" in next(iter(evaluator.causes))


class MethodRunner:
    """Sends the method of a function apart from its object, as pymoo's RayParallelization does."""

    def __call__(self, f, X):
        method = pickle.loads(pickle.dumps(f.__call__.__func__))
        return [method(pickle.loads(pickle.dumps(f)), x) for x in X]


def test_a_runner_that_sends_methods_gives_the_serial_front():
    serial = solve(Element(), MGEOReal(0.2, n_walkers=5), 5)
    parallel = solve(Element(elementwise_runner=MethodRunner()), MGEOReal(0.2, n_walkers=5), 5)
    assert np.array_equal(parallel.F, serial.F)
    assert parallel.algorithm.evaluator.causes == serial.algorithm.evaluator.causes


class BrokenRunner:
    def __call__(self, f, X):
        raise ConnectionError("no scheduler")


@pytest.mark.parametrize("algorithm", [MGEOReal(n_walkers=5), NSGA2(20)], ids=["mgeo", "nsga2"])
def test_an_error_of_the_runner_ends_the_run_with_that_error(algorithm):
    evaluator = TolerantEvaluator()
    with pytest.raises(ConnectionError, match="no scheduler"):
        solve(Element(elementwise_runner=BrokenRunner()), algorithm, evaluator=evaluator)
    assert evaluator.n_failed == 0


def test_an_interrupt_ends_a_run():
    with pytest.raises(KeyboardInterrupt):
        TolerantEvaluator().eval(Element("interrupt"), candidates())


def solve(problem, algorithm, n_gen=40, **options):
    return minimize(problem, algorithm, ("n_gen", n_gen), **{"seed": 1, **options})


@pytest.mark.parametrize(
    ("problem", "alike"),
    [(Batch(), Batch(np.nan)), *((Element(way), Element("nan")) for way in ("raise", "inf"))],
)
def test_a_run_goes_on_and_its_path_does_not_depend_on_the_way_of_failing(problem, alike):
    result = solve(problem, MGEOReal(0.2, n_walkers=5))
    expected = solve(alike, MGEOReal(0.2, n_walkers=5), evaluator=Evaluator())
    assert np.array_equal(result.X, expected.X)
    assert np.array_equal(result.F, expected.F)
    evaluator = result.algorithm.evaluator
    assert evaluator.n_eval == 40 * 10
    assert evaluator.n_failed == result.algorithm.front.n_rejected > 0


DIRECTIONS = get_reference_directions("das-dennis", 2, n_partitions=19)


@pytest.mark.parametrize(
    ("algorithm", "way"), [(NSGA2(20), "raise"), (NSGA3(DIRECTIONS, 20), "inf")]
)
def test_pymoos_algorithms_find_a_front_where_some_candidates_fail(algorithm, way):
    result = solve(Element(way), algorithm, evaluator=TolerantEvaluator())
    assert result.algorithm.evaluator.n_failed > 0
    assert np.isfinite(result.F).all()
    assert not any(culprit(x) for x in result.X)
    sound = solve(Element("raise"), NSGA2(20), evaluator=TolerantEvaluator())
    assert result.F[:, 0].min() == pytest.approx(sound.F[:, 0].min(), abs=0.05)


class Never(Problem):
    def __init__(self, first_good=0):
        self.left = first_good
        super().__init__(n_var=2, n_obj=2, xl=0.0, xu=1.0)

    def _evaluate(self, X, out, *args, **kwargs):
        self.left -= 1
        if self.left < 0:
            raise RuntimeError(f"no license {self.left}")
        out["F"] = X


class Failing(Problem):
    """No candidate has finite objectives."""

    def __init__(self, n_obj, n_ieq_constr):
        super().__init__(n_var=2, n_obj=n_obj, n_ieq_constr=n_ieq_constr, xl=0.0, xu=1.0)

    def _evaluate(self, X, out, *args, **kwargs):
        out["F"] = np.full((len(X), self.n_obj), np.nan)
        out["G"] = np.zeros((len(X), self.n_ieq_constr))


@pytest.mark.filterwarnings("ignore:invalid value encountered:RuntimeWarning")  # of SPEA2
@pytest.mark.parametrize(
    ("algorithm", "n_obj"),
    [
        (MGEOReal(n_walkers=2), 2), (NSGA2(8), 2), (NSGA3(DIRECTIONS, 20), 2), (SPEA2(8), 2),
        (GA(8), 1), (DE(8), 1), (PSO(8), 1),
    ],
    ids=lambda value: type(value).__name__,
)  # fmt: skip
@pytest.mark.parametrize("n_constraints", [0, 1])
def test_a_run_in_which_no_candidate_succeeded_has_no_result(algorithm, n_obj, n_constraints):
    evaluator = TolerantEvaluator(patience=1000)
    result = solve(Failing(n_obj, n_constraints), algorithm, 2, evaluator=evaluator)
    assert evaluator.n_failed == evaluator.n_eval > 0
    assert result.F is None
    assert result.X is None


@pytest.mark.parametrize("algorithm", [MGEOReal(n_walkers=2), NSGA2(4)], ids=["mgeo", "nsga2"])
@pytest.mark.parametrize("good", [0, 3])
def test_errors_in_every_candidate_stop_the_run_with_the_first_cause(algorithm, good):
    evaluator = TolerantEvaluator(patience=10)
    with pytest.raises(EvaluationError) as raised:
        solve(Never(good), algorithm, evaluator=evaluator)
    # the batch, its first half, the first candidate
    assert str(raised.value) == (
        "all of the last 12 candidates failed, the first with RuntimeError: no license -3"
    )
    assert "in _evaluate" in raised.value.__notes__[0]
    assert evaluator.n_eval == 4 * good + 8


def test_the_first_exception_is_told_once_and_values_never():
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        solve(Batch(), MGEOReal(0.2, n_walkers=5))
        solve(Element("nan"), MGEOReal(0.2, n_walkers=5))
    assert [str(warning.message)[:32] for warning in told] == ["a candidate failed with ZeroDivi"]
