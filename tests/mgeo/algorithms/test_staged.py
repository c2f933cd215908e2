"""MGEOStaged: increases of the fidelity, and the evaluation of the archive at the end."""

import numpy as np
import pytest
from pymoo.optimize import minimize
from pymoo.problems.multi import BNH, ZDT1

from mgeo import MGEODirected, MGEOStaged, compare
from mgeo.evaluation.dominance import find_nondominated
from tests.mgeo.solved import solve

from .problems import Estimated


@pytest.mark.parametrize("constrained", [False, True])
def test_archive_is_evaluated_again_when_fidelity_increases(constrained):
    problem = Estimated(constrained)
    algorithm = MGEOStaged(fidelity_schedule=(0.5, 0.75), n_walkers=4)
    algorithm.setup(problem, termination=("n_eval", 640), seed=1)
    n_eval_at_start = []  # Evaluations at the beginning of each fidelity level.
    while algorithm.has_next():
        before = algorithm.front.individuals.get("X")
        algorithm.next()
        fidelity, X = problem.batches[-1]
        assert fidelity == algorithm.fidelity
        if fidelity != len(n_eval_at_start):
            continue
        if fidelity:
            np.testing.assert_array_equal(X, before)
            out = {}
            algorithm.problem._evaluate(X, out)
            F = out["F"][find_nondominated(out["F"])]
            if not constrained:
                np.testing.assert_array_equal(algorithm.front.F, F[np.argsort(F[:, 0])])
            archived = algorithm.front.individuals.get("X").tolist()
            assert all(walker in archived for walker in algorithm.walkers.tolist())
            np.testing.assert_array_equal(algorithm.state.incumbents, algorithm.walkers)
        n_eval_at_start.append(algorithm.evaluator.n_eval)
    assert len(n_eval_at_start) == 3
    assert n_eval_at_start[1] - 320 < 64 + len(before)
    result = algorithm.result()
    np.testing.assert_array_equal(result.F, problem.evaluate(result.X, return_values_of=["F"]))
    assert not constrained or (problem.evaluate(result.X, return_values_of=["G"]) <= 0.0).all()


@pytest.mark.parametrize("evaluations", [16, 130, 400])
def test_archive_of_short_run_is_evaluated_at_full_fidelity(evaluations):
    problem = Estimated()
    found = minimize(problem, MGEOStaged(n_walkers=4), ("n_eval", evaluations), seed=1)
    np.testing.assert_array_equal(found.F, problem.evaluate(found.X, return_values_of=["F"]))
    assert find_nondominated(found.F).all()


def test_archive_of_stopped_run_is_evaluated_at_full_fidelity():
    problem, stopped = Estimated(), []

    def stop(state):
        if state.n_evaluations > 100 and not stopped:
            stopped.append(state.build_front()[1])
            state.stop()

    found = solve(problem, MGEOStaged(n_walkers=4), 4000, 1, stop)
    assert found.stop_reason == "signal"
    np.testing.assert_array_equal(found.F, problem.evaluate(found.X, return_values_of=["F"]))
    assert len(found.F) <= len(stopped[0])
    assert not np.isin(found.F, stopped[0]).any()


@pytest.mark.parametrize("batch", [3, 6, 7])
def test_archive_of_run_interrupted_in_generation_is_evaluated_at_full_fidelity(batch):
    # In one of the generations, the archive is evaluated again.
    class Stopped(Estimated):
        def _evaluate(self, X, out, *args, **kwargs):
            if len(self.batches) == batch:
                self.batches.append(None)
                raise KeyboardInterrupt
            super()._evaluate(X, out)

    problem = Stopped()
    found = solve(problem, MGEOStaged((0.5, 0.6), n_walkers=4), 160, 1)
    assert found.stop_reason == "signal"
    np.testing.assert_array_equal(found.F, problem.evaluate(found.X, return_values_of=["F"]))


def test_problem_without_fidelity_levels_gives_result_of_mgeo_directed():
    for problem in (ZDT1(n_var=5), BNH()):
        found, expected = (
            minimize(problem, algorithm, ("n_eval", 900), seed=3)
            for algorithm in (MGEOStaged((0.2, 0.4), n_walkers=6), MGEODirected(n_walkers=6))
        )
        np.testing.assert_array_equal(found.X, expected.X)


def test_invalid_fidelity_schedules_are_rejected():
    with pytest.raises(
        ValueError, match=r"fidelity_schedule = \(0.9, 0.5\): expected ascending numbers"
    ):
        MGEOStaged((0.9, 0.5))
    with pytest.raises(ValueError, match="fidelity_schedule"):
        MGEOStaged((0.5, 1.5))
    with pytest.raises(ValueError, match=r"fidelity_schedule = \(\): expected one or more"):
        MGEOStaged(())
    with pytest.raises(TypeError, match="fidelity_schedule"):
        MGEODirected(fidelity_schedule=(0.5, 0.6))


class Optimistic(Estimated):
    """Problem whose objectives are far too small at low fidelity."""

    def _evaluate(self, X, out, *args, **kwargs):
        super()._evaluate(X, out)
        out["F"] = out["F"] - 10.0 * (2 - self.fidelity)


@pytest.mark.parametrize("schedule", [(0.5, 0.75), (0.87, 1.0), (0.0, 0.4)])
def test_study_records_only_full_fidelity_values(schedule):
    problem, algorithm = Optimistic(), MGEOStaged(schedule, n_walkers=4)
    comparison = compare(problem, {"staged": algorithm}, 400, seeds=[1], grid=[100, 200, 399])
    record = comparison.finished_runs["staged", 1]
    np.testing.assert_array_equal(problem.evaluate(record.X), record.front_F)
    assert (record.F > 0.0).all()
    points = comparison.table["points"].tolist()
    assert (points[0] == 0) == (schedule[-1] > 0.25)
    assert points[-1] == len(record.front_rows) > 3
    # The final evaluation of the archive is recorded at the end of the budget, and its evaluations
    # are counted.
    is_evaluated_at_end = schedule[-1] == 1.0
    assert (record.n_evaluations > 408) == is_evaluated_at_end
    assert not is_evaluated_at_end or (record.evaluation_numbers == 400).all()
    # A run outside of a study finds the same front.
    outcome = solve(Optimistic(), algorithm, 400, 1)
    if is_evaluated_at_end:
        np.testing.assert_array_equal(outcome.F, record.front_F[np.argsort(record.front_F[:, 0])])
