"""A run restored from plain data goes on as the run itself does, bit for bit."""

import copy
import json
import pickle
from dataclasses import dataclass, fields

import numpy as np
import pytest
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.core.problem import Problem
from pymoo.core.termination import NoTermination
from pymoo.core.variable import Binary, Integer, Real
from pymoo.operators.sampling.lhs import LHS
from pymoo.problems.multi import BNH, ZDT1
from pymoo.termination.default import DefaultMultiObjectiveTermination
from pymoo.util.archive import MultiObjectiveArchive

import mgeo.algorithms
from mgeo import MGEOCanonical, MGEODirected, MGEOReal, MGEOReal2, ParetoArchive
from mgeo.algorithms import RunState, SavedState, capture, full_name, restore

from .problems import Fixed, Mixture
from .variants import VARIANTS

NAMES = [name for name in mgeo.algorithms.__all__ if name.startswith("MGEO")]
PUBLISHED = [getattr(mgeo.algorithms, name) for name in NAMES]
VALUES = ("X", "F", "G", "H", "CV", "n_gen")


def through_json(saved):
    return SavedState(dict(saved.arrays), json.loads(json.dumps(saved.data)))


def begun(algorithm, problem, generations, n_gen=12):
    run = copy.deepcopy(algorithm).setup(problem, termination=("n_gen", n_gen), seed=3)
    for _ in range(generations):
        run.next()
    return run


def twin(run):
    """The algorithm of a run, made again from its parameters."""
    return type(run)(**run.get_params())


def again(run, **options):
    return restore(through_json(capture(run)), run.problem, twin(run), **options)


def assert_same_end(one, two):
    a, b = one.run(), two.run()
    for ours, theirs in ((a.pop, b.pop), (one.front.individuals, two.front.individuals)):
        for x, y in zip(ours.get(*VALUES), theirs.get(*VALUES), strict=True):
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
def test_every_variant_goes_on_bit_for_bit(cls, problem, generations):
    run = begun(cls(n_walkers=3, archive_size=10), problem, generations)
    assert_same_end(again(run), run)


@pytest.mark.parametrize("variant", VARIANTS)
def test_so_does_every_adaptive_and_restarting_one(variant):
    run = begun(variant("a-geo1", 3, restart="archive", patience=2), Mixture(), 7)
    assert_same_end(again(run), run)


class Typed(Problem):
    """Dicts of a real, an integer and a binary variable."""

    def __init__(self):
        variables = {"a": Real(bounds=(-1, 2)), "b": Integer(bounds=(-3, 4)), "c": Binary()}
        super().__init__(vars=variables, n_obj=2)

    def _evaluate(self, X, out, *args, **kwargs):
        out["F"] = np.array([[x["a"] ** 2 + x["b"], x["c"] - x["b"] * x["a"]] for x in X])


class Whole(Problem):
    def __init__(self):
        super().__init__(n_var=3, n_obj=2, xl=-5, xu=5, vtype=int)

    def _evaluate(self, X, out, *args, **kwargs):
        out["F"] = np.column_stack([(X**2).sum(axis=1), ((X - 2) ** 2).sum(axis=1)])


@pytest.mark.parametrize("problem", [Typed(), Whole()], ids=lambda p: p.name())
def test_variables_of_every_type_come_back(problem):
    algorithm = MGEOCanonical(n_walkers=3, bits=5, restart="archive", patience=1)
    run = begun(algorithm, problem, 6)
    assert isinstance(again(run).pop[0].X, type(run.pop[0].X))
    assert_same_end(again(run), run)


def test_a_run_leaves_the_algorithm_it_goes_on_with_as_it_is():
    run = begun(MGEOReal(n_walkers=3), ZDT1(n_var=4), 5)
    fresh = twin(run)
    assert restore(capture(run), run.problem, fresh) is not fresh
    assert fresh.problem is None


def test_parameters_are_kept_and_a_second_restore_is_the_first():
    given = MGEOReal(np.array([0.1, 0.2, 0.3]), 2.5, 4, "range", sampling=LHS(), archive_size=9)
    problem = ZDT1(n_var=3)
    run = begun(given, problem, 5)
    twice = again(again(run))
    assert twice.sigma.tolist() == [0.1, 0.2, 0.3]
    assert (twice.tau, twice.n_walkers, twice.perturbation) == (2.5, 4, "range")
    assert_same_end(twice, run)


def test_streams_spawned_later_are_the_same():
    run = begun(MGEOReal(n_walkers=2), ZDT1(n_var=3), 2)
    run.random_state.spawn(2)
    run.streams[1].spawn(1)
    restored = again(run)
    both = [[a.random_state, *a.streams] for a in (restored, run)]
    for ours, theirs in zip(*both, strict=True):
        assert ours.spawn(1)[0].random() == theirs.spawn(1)[0].random()


def test_nothing_found_and_nothing_feasible():
    for problem in (Fixed([np.nan, 1.0]), Fixed([1.0, 2.0], violation=0.5)):
        run = begun(MGEOReal(n_walkers=2), problem, 3)
        assert_same_end(again(run), run)


@pytest.mark.parametrize(
    ("termination", "generations"),
    [(None, 12), (("n_gen", 15), 15), (("n_eval", 240), 20), (("n_gen", 5), 6), (("n_gen", 6), 6)],
)
def test_a_new_termination_counts_from_the_first_generation(termination, generations):
    restored = again(begun(MGEOReal(n_walkers=3), ZDT1(n_var=4), 6), termination=termination)
    while restored.has_next():
        restored.next()
    assert restored.n_generations == generations


def test_time_stands_still_between_the_runs(monkeypatch):
    run = begun(MGEOReal(n_walkers=3), ZDT1(n_var=4), 2)
    run.start_time -= 40.0
    saved = capture(run)
    monkeypatch.setattr("time.time", lambda: run.start_time + 1e6)
    restored = restore(saved, run.problem, twin(run), termination=("time", 50.0))
    assert restored.termination.perc == pytest.approx(0.8, abs=0.1)


def test_terminations_without_a_budget():
    problem = ZDT1(n_var=4)
    run = begun(MGEOReal(n_walkers=3), problem, 3)
    run.termination = NoTermination()
    assert again(run).has_next()
    run.termination = DefaultMultiObjectiveTermination()
    with pytest.raises(ValueError, match=r"termination = None: .* expected a new one"):
        again(run)
    assert again(run, termination=("n_gen", 4)).has_next()


def test_no_state_to_be_had_is_refused():
    problem = ZDT1(n_var=4)
    with pytest.raises(ValueError, match="expected one that was set up"):
        capture(MGEOReal())
    run = begun(MGEOReal(n_walkers=3), problem, 1)
    run.ask()
    with pytest.raises(ValueError, match="waits for tell"):
        capture(run)
    run = MGEOReal(archive=MultiObjectiveArchive()).setup(problem)
    with pytest.raises(ValueError, match="archive"):
        capture(run)
    run = begun(MGEOReal(n_walkers=3), problem, 1)
    with pytest.raises(AttributeError):
        run.walkers = run.walkers.copy()
    run.state.walkers = run.walkers.tolist()
    with pytest.raises(TypeError, match=r"state.walkers = \[.*expected an array of numbers"):
        capture(run)


class Odd(MGEOReal):
    def __init__(self, odd, **options):
        super().__init__(**options)
        self.odd = odd


def test_parameters_that_are_no_data_are_refused():
    run = Odd([1, object()]).setup(ZDT1(n_var=4))
    with pytest.raises(TypeError, match=r"Odd.odd\[1\] = <object"):
        capture(run)
    run = MGEOReal(seed=np.random.MT19937(1)).setup(ZDT1(n_var=4))
    with pytest.raises(TypeError, match="MT19937"):
        capture(run)


def test_what_does_not_fit_is_refused():
    run = begun(MGEOReal(n_walkers=3), ZDT1(n_var=4), 2)
    saved = capture(run)
    unknown = SavedState(saved.arrays, {**saved.data, "class": "os.system"})
    with pytest.raises(ValueError, match=r"class = 'os\.system': the algorithm given is a mgeo"):
        restore(unknown, run.problem, twin(run))
    with pytest.raises(ValueError, match=r"the algorithm given is a .*\.MGEOReal2"):
        restore(saved, run.problem, MGEOReal2(n_walkers=3))
    with pytest.raises(ValueError, match=r"parameters\.tau = 3\.0: that given has 2\.5"):
        restore(saved, run.problem, MGEOReal(n_walkers=3, tau=2.5))
    foreign = SavedState(saved.arrays, {**saved.data, "class": full_name(NSGA2), "parameters": {}})
    with pytest.raises(ValueError, match=r"the algorithm given is a .*\.NSGA2"):
        restore(foreign, run.problem, NSGA2())
    arrays = {key: value for key, value in saved.arrays.items() if key != "state.walkers"}
    with pytest.raises(ValueError, match=r"state\.walkers is missing"):
        restore(SavedState(arrays, saved.data), run.problem, twin(run))
    bad = {"state.walkers": np.zeros((3, 5)), "state.front_F": saved.arrays["state.front_F"][:0]}
    for key, array in bad.items():
        with pytest.raises(ValueError, match=rf"{key} of shape .* expected \("):
            restore(SavedState({**saved.arrays, key: array}, saved.data), run.problem, twin(run))
    for key, value, message in (
        ("n_generations", -1, "state.n_generations = -1"),
        ("n_generations", None, "state.n_generations = None: expected an integer"),
        ("streams", saved.data["state"]["streams"][:2], "state.streams: 2 streams, expected 3"),
        ("streams", [1, 2, 3], "no state of a random stream"),
    ):
        data = {**saved.data, "state": {**saved.data["state"], key: value}}
        with pytest.raises((ValueError, TypeError), match=message):
            restore(SavedState(saved.arrays, data), run.problem, twin(run))


# What pymoo's own loop changes: `capture` keeps it, or it is to be given again (`callback` and on).
OF_PYMOO = {
    "n_iter", "pop", "off", "opt", "evaluator", "random_state", "is_initialized", "start_time",
    "termination", "callback", "output", "display", "history",
}  # fmt: skip


def changed_attributes(algorithm, problem):
    """Names of all attributes that some generation makes, removes, replaces or changes inside."""
    run = begun(algorithm, problem, 0, n_gen=40)
    changed = set()
    for _ in range(12):
        before = {key: pickle.dumps(value) for key, value in vars(run).items()}
        run.next()
        after = {key: pickle.dumps(value) for key, value in vars(run).items()}
        changed |= {key for key in before | after if before.get(key) != after.get(key)}
    return changed


class SoonRestarted(MGEODirected):
    restart = (1, 2)


ALGORITHMS = [
    *(cls(n_walkers=3, archive_size=10) for cls in PUBLISHED),
    SoonRestarted(n_walkers=4, extreme_weights=0.5, max_candidates=2),
    MGEODirected(n_walkers=4, momentum=(0.0, 0.0)),
    *(variant("a-geo2", 3, restart="random", patience=2) for variant in VARIANTS),
]


@pytest.mark.cases(2)
@pytest.mark.parametrize("algorithm", ALGORITHMS, ids=lambda a: type(a).__name__)
@pytest.mark.parametrize("problem", [ZDT1(n_var=4), BNH()], ids=lambda p: p.name())
def test_all_that_a_generation_changes_is_in_the_state_or_pymoos(algorithm, problem):
    assert changed_attributes(algorithm, problem) - OF_PYMOO == {"state"}


class Forgetful(MGEOReal):
    """Counts in an attribute what it should count in its state."""

    counted = 0

    def accept(self, F, violation):
        self.counted += 1
        return super().accept(F, violation)


def test_an_attribute_that_is_not_declared_would_be_noticed():
    changed = changed_attributes(Forgetful(n_walkers=3), ZDT1(n_var=4))
    assert changed - OF_PYMOO == {"state", "counted"}


@dataclass(kw_only=True, eq=False, slots=True)
class Counts(RunState):
    accepted: np.ndarray
    shift: float
    phase: str
    spare: np.random.Generator
    extremes: ParetoArchive


class Counting(MGEOReal):
    """A variant with a state of its own, on which its way depends."""

    def new_state(self, streams, front, walkers):
        return Counts.begin(
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


def test_a_variant_with_a_state_of_its_own_goes_on_bit_for_bit():
    run = begun(Counting(n_walkers=3), ZDT1(n_var=4), 5)
    restored = again(run)
    for field in ("shift", "phase"):
        assert getattr(restored.state, field) == getattr(run.state, field)
    assert restored.state.accepted.tolist() == [5, 5, 5]
    assert np.array_equal(restored.state.extremes.F, run.state.extremes.F)
    assert_same_end(restored, run)
    assert run.state.spare.random() == restored.state.spare.random()


def test_what_is_not_declared_cannot_be_set_or_is_refused():
    run = begun(MGEOReal(n_walkers=3), ZDT1(n_var=4), 1)
    with pytest.raises(AttributeError):
        run.state.forgotten = 1
    loose = type("Loose", (RunState,), {})  # no dataclass with slots
    run.state = loose(**{field.name: getattr(run.state, field.name) for field in fields(RunState)})
    assert again(run).n_generations == 1
    run.state.forgotten = 1
    with pytest.raises(TypeError, match=r"state.forgotten is no declared field of .*Loose"):
        capture(run)
