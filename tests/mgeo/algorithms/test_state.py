"""A run that is restored from JSON values and arrays equals the uninterrupted run exactly."""

import copy
import json
from dataclasses import dataclass

import numpy as np
import pytest
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.core.problem import Problem
from pymoo.problems.multi import BNH, ZDT1
from pymoo.termination.default import DefaultMultiObjectiveTermination
from pymoo.util.archive import MultiObjectiveArchive

import mgeo.algorithms
from mgeo import MGEOCanonical, MGEOReal, MGEOReal2, ParetoArchive
from mgeo.algorithms import RunState, SavedState, capture, restore
from mgeo.validation.entries import FileError

from .problems import Fixed, Mixture, Typed

NAMES = [name for name in mgeo.algorithms.__all__ if name.startswith("MGEO")]
PUBLISHED = [getattr(mgeo.algorithms, name) for name in NAMES]
VALUES = ("X", "F", "G", "H", "CV", "n_gen")


def through_json(saved):
    return SavedState(dict(saved.arrays), json.loads(json.dumps(saved.data)))


def start_run(algorithm, problem, generations, n_gen=12):
    run = copy.deepcopy(algorithm).setup(problem, termination=("n_gen", n_gen), seed=3)
    for _ in range(generations):
        run.next()
    return run


def rebuild_algorithm(run):
    """Return a new algorithm with the parameters of a run."""
    return type(run)(**run.get_params())


def save_and_restore(run, **options):
    return restore(through_json(capture(run)), run.problem, rebuild_algorithm(run), **options)


def assert_same_end(one, two):
    a, b = one.run(), two.run()
    for a_values, b_values in ((a.pop, b.pop), (one.front.individuals, two.front.individuals)):
        for x, y in zip(a_values.get(*VALUES), b_values.get(*VALUES), strict=True):
            assert x.dtype == y.dtype
            assert np.array_equal(x, y, equal_nan=x.dtype != object)
    assert np.array_equal(one.front.F, two.front.F)
    assert one.front.violation == two.front.violation
    assert one.front.n_rejected == two.front.n_rejected
    assert (one.n_gen, one.evaluator.n_eval) == (two.n_gen, two.evaluator.n_eval)
    assert one.random_state.random() == two.random_state.random()
    assert [s.random() for s in one.streams] == [s.random() for s in two.streams]


@pytest.mark.cases(2)
@pytest.mark.parametrize("cls", PUBLISHED)
@pytest.mark.parametrize(
    ("problem", "generations"),
    [(ZDT1(n_var=4), 7), (BNH(), 7), (Mixture(), 0), (Mixture(), 1), (Mixture(), 12)],
    ids=lambda value: value.name() if isinstance(value, Problem) else str(value),
)
def test_resumed_run_equals_uninterrupted_run(cls, problem, generations):
    run = start_run(cls(n_walkers=3, archive_size=10), problem, generations)
    assert_same_end(save_and_restore(run), run)


class IntegerProblem(Problem):
    def __init__(self):
        super().__init__(n_var=3, n_obj=2, xl=-5, xu=5, vtype=int)

    def _evaluate(self, X, out, *args, **kwargs):
        out["F"] = np.column_stack([(X**2).sum(axis=1), ((X - 2) ** 2).sum(axis=1)])


@pytest.mark.parametrize("problem", [Typed(), IntegerProblem()], ids=lambda p: p.name())
def test_variables_of_every_type_are_restored(problem):
    algorithm = MGEOCanonical(n_walkers=3, bits=5, restart="archive", patience=1)
    run = start_run(algorithm, problem, 6)
    assert isinstance(save_and_restore(run).pop[0].X, type(run.pop[0].X))
    assert_same_end(save_and_restore(run), run)


def test_runs_without_feasible_points_are_restored():
    for problem in (Fixed([np.nan, 1.0]), Fixed([1.0, 2.0], violation=0.5)):
        run = start_run(MGEOReal(n_walkers=2), problem, 3)
        assert_same_end(save_and_restore(run), run)


@pytest.mark.parametrize(
    ("termination", "generations"),
    [(None, 12), (("n_gen", 15), 15), (("n_eval", 240), 20), (("n_gen", 5), 6), (("n_gen", 6), 6)],
)
def test_new_termination_counts_from_first_generation(termination, generations):
    restored = save_and_restore(
        start_run(MGEOReal(n_walkers=3), ZDT1(n_var=4), 6), termination=termination
    )
    while restored.has_next():
        restored.next()
    assert restored.n_generations == generations


def test_time_between_runs_is_not_counted(monkeypatch):
    run = start_run(MGEOReal(n_walkers=3), ZDT1(n_var=4), 2)
    run.start_time -= 40.0
    saved = capture(run)
    monkeypatch.setattr("time.time", lambda: run.start_time + 1e6)
    restored = restore(saved, run.problem, rebuild_algorithm(run), termination=("time", 50.0))
    assert restored.termination.perc == pytest.approx(0.8, abs=0.1)


@dataclass(kw_only=True, eq=False, slots=True)
class Counts(RunState):
    accepted: np.ndarray
    shift: float
    phase: str
    spare: np.random.Generator
    extremes: ParetoArchive


class Counting(MGEOReal):
    """Variant with additional state that affects the search."""

    def create_state(self, streams, front, walkers):
        return Counts.create(
            streams, front, walkers, accepted=np.zeros(len(walkers), dtype=int), shift=0.0,
            phase="first", spare=np.random.default_rng(5), extremes=ParetoArchive(2, 4),
        )  # fmt: skip

    def accept(self, F, violation):
        state = self.state
        state.extremes.add(state.front.F, state.front.individuals)
        state.accepted += 1
        state.shift += state.spare.random() * state.accepted[0]
        state.phase = "later"
        return super().accept(F + state.shift * F[:, ::-1], violation)


def test_resumed_run_with_additional_state_equals_uninterrupted_run():
    run = start_run(Counting(n_walkers=3), ZDT1(n_var=4), 5)
    restored = save_and_restore(run)
    for field in ("shift", "phase"):
        assert getattr(restored.state, field) == getattr(run.state, field)
    assert restored.state.accepted.tolist() == [5, 5, 5]
    assert np.array_equal(restored.state.extremes.F, run.state.extremes.F)
    assert_same_end(restored, run)
    assert run.state.spare.random() == restored.state.spare.random()


def test_termination_other_than_budget_must_be_passed_again():
    run = start_run(MGEOReal(n_walkers=3), ZDT1(n_var=4), 3)
    run.termination = DefaultMultiObjectiveTermination()
    with pytest.raises(
        ValueError, match="termination of the run was not saved: expected a new one"
    ):
        save_and_restore(run)
    assert save_and_restore(run, termination=("n_gen", 4)).has_next()


def test_state_is_captured_only_between_generations():
    run = MGEOReal(n_walkers=3)
    with pytest.raises(ValueError, match="not between two generations"):
        capture(run)
    run.setup(ZDT1(n_var=4)).ask()
    with pytest.raises(ValueError, match="not between two generations"):
        capture(run)
    run = MGEOReal(archive=MultiObjectiveArchive()).setup(ZDT1(n_var=4))
    with pytest.raises(ValueError, match="archive"):
        capture(run)


def test_other_algorithm_or_parameter_is_rejected():
    run = start_run(MGEOReal(n_walkers=3), ZDT1(n_var=4), 2)
    saved = capture(run)
    for other, message in (
        (MGEOReal2(n_walkers=3), r"the algorithm given is a .*\.MGEOReal2"),
        (NSGA2(), r"the algorithm given is a .*\.NSGA2"),
        (MGEOReal(n_walkers=3, tau=2.5), r"parameters\.tau = 3\.0: the algorithm given has 2\.5"),
    ):
        with pytest.raises(ValueError, match=message):
            restore(saved, run.problem, other)


@pytest.mark.parametrize(
    ("arrays", "message"),
    [
        ({"state.walkers": np.zeros((3, 5))}, r"state.walkers of shape \(3, 5\): expected"),
        ({"state.front_F": np.zeros((0, 2))}, "state.front: expected the same number of rows"),
    ],
)
def test_damaged_state_is_rejected(arrays, message):
    run = start_run(MGEOReal(n_walkers=3), ZDT1(n_var=4), 2)
    saved = capture(run)
    with pytest.raises(FileError, match=f"run.checkpoint: .*{message}"):
        restore(
            SavedState(saved.arrays | arrays, saved.data, "run.checkpoint"),
            run.problem,
            rebuild_algorithm(run),
        )
