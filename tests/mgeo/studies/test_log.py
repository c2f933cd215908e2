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

objective_values = st.sampled_from([0.0, 1.0, 2.0, 3.0, 4.0, np.nan, np.inf])


def sorted_front(F):
    return sorted(map(tuple, F[nondominated_rows(F)]))


def log_batches(batches, feasible, n_eval):
    log = EvaluationLog(batches[0].shape[1], n_eval)
    for F, is_feasible in zip(batches, feasible, strict=True):
        X = np.arange(log.n_evaluations, log.n_evaluations + len(F))[:, None] * [1.0, -1.0]
        population = Population.new("X", X, "F", F)
        for individual, satisfied in zip(population, is_feasible, strict=True):
            individual.G = np.array([-1.0 if satisfied else 1.0])
        log(population)
    return log.build_run(0.5)


@pytest.mark.slow
@given(st.data())
def test_front_of_log_equals_front_of_all_evaluations(data):
    n_obj = data.draw(st.integers(2, 3))
    sizes = data.draw(st.lists(st.integers(1, 6), min_size=1, max_size=5))
    batches = [data.draw(arrays(float, (size, n_obj), elements=objective_values)) for size in sizes]
    feasible = [data.draw(arrays(bool, size)) for size in sizes]
    n_eval = data.draw(st.integers(1, sum(sizes)))
    run = log_batches(batches, feasible, n_eval)
    F, is_valid = np.concatenate(batches), np.concatenate(feasible)
    is_valid &= np.isfinite(F).all(axis=1)
    grid = range(1, n_eval + 1)
    for n, front in zip(grid, run.iterate_fronts(grid), strict=True):
        assert sorted(map(tuple, front)) == sorted_front(F[:n][is_valid[:n]])
    assert sorted(map(tuple, run.front_F)) == sorted_front(F[:n_eval][is_valid[:n_eval]])
    # X contains the number of the evaluation, which identifies the solutions of the front.
    if len(run.front_rows):
        assert np.array_equal(run.X[:, 0], run.evaluation_numbers[run.front_rows] - 1)
        assert np.array_equal(F[run.X[:, 0].astype(int)], run.front_F)
    assert run.n_evaluations == len(F)


def test_log_contains_every_evaluation_of_algorithm_once():
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
    run = log.build_run(1.5)
    assert (run.n_eval, run.n_evaluations, run.wall_time) == (73, 100, 1.5)
    assert sorted(map(tuple, run.front_F)) == sorted_front(problem.evaluate(X[:73]))
    assert np.array_equal(problem.evaluate(run.X), run.front_F)


def test_stored_run_is_read_back_exactly(tmp_path):
    run = log_batches([np.array([[1.0, 2.0], [np.pi, 0.1]])], [np.array([True, True])], 2)
    first_path, second_path = tmp_path / "first.npz", tmp_path / "second.npz"
    run.write(first_path)
    read = StudyRun.read(first_path)
    for name, value in vars(run).items():
        assert np.array_equal(getattr(read, name), value), name
        assert type(getattr(read, name)) is type(value)
    read.write(second_path)
    assert second_path.read_bytes() == first_path.read_bytes()
