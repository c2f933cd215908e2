import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.core.population import Population
from pymoo.problems.multi import ZDT1

from mgeo.runs.algorithms import set_up
from mgeo.studies.run import EvaluationLog, ReportingEvaluator
from mgeo.studies.study_run import StudyRun

from ..naive import nondominated_rows

values = st.sampled_from([0.0, 1.0, 2.0, 3.0, 4.0, np.nan, np.inf])


def front(F):
    return sorted(map(tuple, F[nondominated_rows(F)]))


def watched(batches, feasible, n_eval):
    log = EvaluationLog(batches[0].shape[1], n_eval)
    for F, ok in zip(batches, feasible, strict=True):
        X = np.arange(log.n_evaluations, log.n_evaluations + len(F))[:, None] * [1.0, -1.0]
        population = Population.new("X", X, "F", F)
        for individual, one in zip(population, ok, strict=True):
            individual.G = np.array([-1.0 if one else 1.0])
        log(population)
    return log.build_run(0.5)


@pytest.mark.slow
@given(st.data())
def test_the_front_after_any_number_of_evaluations_is_that_of_all_of_them(data):
    n_obj = data.draw(st.integers(2, 3))
    sizes = data.draw(st.lists(st.integers(1, 6), min_size=1, max_size=5))
    batches = [data.draw(arrays(float, (size, n_obj), elements=values)) for size in sizes]
    feasible = [data.draw(arrays(bool, size)) for size in sizes]
    n_eval = data.draw(st.integers(1, sum(sizes)))
    record = watched(batches, feasible, n_eval)
    F, usable = np.concatenate(batches), np.concatenate(feasible)
    usable &= np.isfinite(F).all(axis=1)
    grid = range(1, n_eval + 1)
    for n, found in zip(grid, record.iterate_fronts(grid), strict=True):
        assert sorted(map(tuple, found)) == front(F[:n][usable[:n]])
    assert sorted(map(tuple, record.front_F)) == front(F[:n_eval][usable[:n_eval]])
    # the solutions that go with the front: X tells the number of the evaluation
    if len(record.front_rows):
        assert np.array_equal(record.X[:, 0], record.evaluation_numbers[record.front_rows] - 1)
        assert np.array_equal(F[record.X[:, 0].astype(int)], record.front_F)
    assert record.n_evaluations == len(F)


def test_every_evaluation_of_an_algorithm_is_seen_once():
    problem, evaluated = ZDT1(n_var=4), []
    algorithm = set_up(problem, NSGA2(pop_size=10), 100, seed=1)
    evaluate = problem._evaluate
    problem._evaluate = lambda X, out, *args, **kwargs: (
        evaluated.append(X.copy()),
        evaluate(X, out),
    )
    log = EvaluationLog(2, 73)
    algorithm.evaluator = ReportingEvaluator(algorithm.evaluator, lambda _, *batch: log(*batch))
    algorithm.run()
    X = np.concatenate(evaluated)
    assert (log.n_evaluations, len(X), algorithm.evaluator.n_eval) == (100, 100, 100)
    problem._evaluate = evaluate
    record = log.build_run(1.5)
    assert (record.n_eval, record.n_evaluations, record.wall_time) == (73, 100, 1.5)
    assert sorted(map(tuple, record.front_F)) == front(problem.evaluate(X[:73]))
    assert np.array_equal(problem.evaluate(record.X), record.front_F)


def test_a_record_survives_its_file(tmp_path):
    record = watched([np.array([[1.0, 2.0], [np.pi, 0.1]])], [np.array([True, True])], 2)
    one, other = tmp_path / "one.npz", tmp_path / "other.npz"
    record.write(one)
    again = StudyRun.read(one)
    for name, value in vars(record).items():
        assert np.array_equal(getattr(again, name), value), name
        assert type(getattr(again, name)) is type(value)
    again.write(other)
    assert other.read_bytes() == one.read_bytes()
