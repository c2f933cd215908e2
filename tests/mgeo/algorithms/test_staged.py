"""MGEOStaged: what happens at the beginning of a stage, and at the end."""

import numpy as np
import pytest
from pymoo.optimize import minimize
from pymoo.problems.multi import BNH, ZDT1

from mgeo import MGEODirected, MGEOStaged, compare
from mgeo.evaluation.dominance import find_nondominated
from tests.mgeo.solved import solve

from .problems import Estimated


@pytest.mark.parametrize("constrained", [False, True])
def test_a_stage_begins_with_the_archive_judged_anew(constrained):
    problem = Estimated(constrained)
    algorithm = MGEOStaged(fidelity_schedule=(0.5, 0.75), n_walkers=4)
    algorithm.setup(problem, termination=("n_eval", 640), seed=1)
    began = []
    while algorithm.has_next():
        before = algorithm.front.individuals.get("X")
        algorithm.next()
        stage, X = problem.batches[-1]
        assert stage == algorithm.fidelity
        if stage != len(began):
            continue
        if stage:
            np.testing.assert_array_equal(X, before)
            out = {}
            algorithm.problem._evaluate(X, out)
            F = out["F"][find_nondominated(out["F"])]
            if not constrained:
                np.testing.assert_array_equal(algorithm.front.F, F[np.argsort(F[:, 0])])
            known = algorithm.front.individuals.get("X").tolist()
            assert all(walker in known for walker in algorithm.walkers.tolist())
            np.testing.assert_array_equal(algorithm.state.incumbents, algorithm.walkers)
        began.append(algorithm.evaluator.n_eval)
    assert len(began) == 3
    assert began[1] - 320 < 64 + len(before)
    found = algorithm.result()
    np.testing.assert_array_equal(found.F, problem.evaluate(found.X, return_values_of=["F"]))
    assert not constrained or (problem.evaluate(found.X, return_values_of=["G"]) <= 0.0).all()


@pytest.mark.parametrize("evaluations", [16, 130, 400])
def test_a_run_that_ends_before_is_judged_as_in_the_last(evaluations):
    problem = Estimated()
    found = minimize(problem, MGEOStaged(n_walkers=4), ("n_eval", evaluations), seed=1)
    np.testing.assert_array_equal(found.F, problem.evaluate(found.X, return_values_of=["F"]))
    assert find_nondominated(found.F).all()


def test_so_is_one_that_was_stopped():
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
def test_so_is_one_that_was_stopped_amid_a_generation(batch):
    """Also in that in which the archive is judged anew."""

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


def test_of_a_problem_without_stages_it_is_the_directed_search():
    for problem in (ZDT1(n_var=5), BNH()):
        found, expected = (
            minimize(problem, algorithm, ("n_eval", 900), seed=3)
            for algorithm in (MGEOStaged((0.2, 0.4), n_walkers=6), MGEODirected(n_walkers=6))
        )
        np.testing.assert_array_equal(found.X, expected.X)


def test_stages_are_shares_in_order():
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


class Rough(Estimated):
    """Whose estimates are far better than what they stand for."""

    def _evaluate(self, X, out, *args, **kwargs):
        super()._evaluate(X, out)
        out["F"] = out["F"] - 10.0 * (2 - self.fidelity)


STAGES = [(0.5, 0.75), (0.87, 1.0), (0.0, 0.4)]


@pytest.mark.parametrize("stages", STAGES)
def test_a_study_knows_values_of_the_last_stage_alone(stages):
    problem, algorithm = Rough(), MGEOStaged(stages, n_walkers=4)
    found = compare(problem, {"staged": algorithm}, 400, seeds=[1], grid=[100, 200, 399])
    record = found.finished_runs["staged", 1]
    np.testing.assert_array_equal(problem.evaluate(record.X), record.front_F)
    assert (record.F > 0.0).all()
    points = found.table["points"].tolist()
    assert (points[0] == 0) == (stages[-1] > 0.25)
    assert points[-1] == len(record.front_rows) > 3
    # a judgment at the end counts with the last evaluation, and its own are told
    judged = stages[-1] == 1.0
    assert (record.n_evaluations > 408) == judged
    assert not judged or (record.evaluation_numbers == 400).all()
    # the same front as a run by itself has
    own = solve(Rough(), algorithm, 400, 1)
    if judged:
        np.testing.assert_array_equal(own.F, record.front_F[np.argsort(record.front_F[:, 0])])
