"""A run that begins with what its problem suggests, and ends with what it refines."""

import numpy as np
import pytest

from mgeo import read_record
from mgeo.plugins.problems import load_problem
from mgeo.runs.prepare import PreparedRun, prepare_run, resume_run

pytestmark = pytest.mark.usefixtures("stand_in")
SMALL = {"n_walkers": 4}


def begun(starts=0, polish=False, **options):
    options = {"parameters": SMALL, "evaluations": 160, "seed": 2} | options
    return prepare_run("cantilever", initial_designs=starts, refine=polish, **options)


def test_what_is_refined_takes_the_place_of_what_was_found():
    search, outcome = begun().solve(), begun(polish=True).solve()
    assert outcome.n_evaluations == search.n_evaluations
    assert (search.n_refined, outcome.n_refined) == (0, (search.X[:, 1] > 0.2).sum())
    assert (outcome.X[:, 1] == 0.2).all()
    F = load_problem("cantilever").evaluate(outcome.X)
    np.testing.assert_array_equal(F, outcome.F)
    for before in search.F:
        assert (before >= outcome.F).all(axis=1).any()
    assert outcome.hypervolume > search.hypervolume


def test_suggested_designs_are_the_first_of_a_run(tmp_path):
    run = begun(starts=3, record=True)
    outcome = run.solve(folder=tmp_path)
    record = read_record(tmp_path / "evaluations")
    assert len(record) == outcome.n_evaluations
    np.testing.assert_allclose(record["length [m]"][:3], 0.2)
    assert record["generation"][2] == 1
    again = PreparedRun.from_configuration(run.configuration).solve()
    np.testing.assert_array_equal(again.F, outcome.F)


class Killed(BaseException):
    pass


@pytest.mark.parametrize("step", [0, 5])
def test_a_run_that_was_killed_while_it_refines_ends_as_it_would_have(step, tmp_path):
    run = begun(polish=True)
    steps = []

    def kill(state):
        if state.refinement is not None:
            steps.append(state.n_evaluations)
            if len(steps) > step:
                raise Killed

    with pytest.raises(Killed):
        run.solve(kill, tmp_path)
    expected, resumed = begun(polish=True).solve(), resume_run(tmp_path)
    assert resumed.configuration == run.configuration
    outcome = resumed.solve()
    np.testing.assert_array_equal(outcome.X, expected.X)
    assert (outcome.n_refined, outcome.stop_reason) == (expected.n_refined, "budget")


def refines(monkeypatch, method):
    monkeypatch.setattr(type(load_problem("cantilever")), "refine", method)


def longer(self, X):
    yield X + np.array([0.0, 0.01])


def adds(self, X):
    """Twice a longer beam beyond those given, at first one that is no beam, then better ones."""
    if len(X):
        more = np.array([[X[:, 0].min() * 0.5, 0.2], [X[:, 0].min() * 0.7, 0.2]])
        yield np.vstack([X, more[:1]])
        yield np.vstack([X, more])
        yield np.vstack([X + np.array([0.0, 0.01]), more * np.array([1.0, 1.1])])


def breaks(self, X):
    if len(X):
        better = X.copy()
        better[X[:, 1].argmax(), 1] = 0.2
        yield better
        raise RuntimeError("no more")


@pytest.mark.parametrize(
    ("method", "kept", "message"),
    [
        (longer, slice(None), ""),
        (breaks, slice(1, None), "refine of problem Cantilever raised RuntimeError: no more"),
    ],
)
def test_what_fails_or_is_no_better_keeps_what_was_given(method, kept, message, monkeypatch):
    search = begun().solve()
    refines(monkeypatch, method)
    outcome = begun(polish=True).solve()
    assert message in outcome.refinement_error
    assert bool(outcome.refinement_error) == bool(message)
    assert outcome.n_refined == (method is breaks)
    assert outcome.stop_reason == "budget"
    of_search = {tuple(row) for row in search.X}
    assert len([row for row in outcome.X if tuple(row) in of_search]) >= len(outcome.X) - 1


def test_what_is_given_beyond_the_front_is_added(monkeypatch):
    search = begun().solve()
    refines(monkeypatch, adds)
    run, sizes = begun(polish=True), []

    def see(state):
        if state.refinement is not None:
            sizes.append(len(state.refinement.solutions))

    outcome = run.solve(see)
    assert (outcome.n_refined, outcome.n_added) == (0, 2)
    n = len(search.X)
    assert sizes[:3] == [n + 1, n + 2, n + 2]
    added = search.X[:, 0].min() * np.array([0.5, 0.7])
    for diameter in added:
        assert [diameter, 0.2] in outcome.X.tolist()
    F = load_problem("cantilever").evaluate(outcome.X)
    np.testing.assert_array_equal(F, outcome.F)
    assert outcome.hypervolume >= search.hypervolume


def test_what_cannot_be_asked_of_a_problem_is_told_before_the_search(monkeypatch):
    def none(self, X):
        raise ValueError("two objectives alone")

    refines(monkeypatch, none)
    with pytest.raises(ValueError, match="refine of problem Cantilever raised ValueError: two"):
        begun(polish=True)
    monkeypatch.delattr(type(load_problem("cantilever")), "refine")
    with pytest.raises(ValueError, match=r"problem Cantilever has no refine\(\)"):
        begun(polish=True)
    with pytest.raises(
        ValueError, match=r"initial_designs = 5: expected at most 4, the initial size of MGEODirect"
    ):
        begun(starts=5)
    with pytest.raises(
        ValueError, match="initial_designs = 1: RandomSearch accepts no initial designs"
    ):
        begun(starts=1, algorithm="random", parameters={})
    monkeypatch.delattr(type(load_problem("cantilever")), "suggest_initial_designs")
    with pytest.raises(ValueError, match=r"Cantilever has no suggest_initial_designs\(\)"):
        begun(starts=1)


def test_a_problem_recommends_both_for_runs_that_are_told_nothing_else(monkeypatch):
    def configuration(**options):
        found = prepare_run(
            "cantilever", **({"initial_designs": None, "refine": None} | options)
        ).configuration
        return found.initial_designs, found.refine

    assert configuration() == (0, False)
    of = type(load_problem("cantilever"))
    advice = {"initial_designs": 2, "refine": True}
    monkeypatch.setattr(of, "recommend_settings", lambda self: advice, raising=False)
    assert configuration() == (2, True)
    assert configuration(initial_designs=0) == (0, True)
    assert configuration(refine=False) == (2, False)
    assert prepare_run("cantilever").configuration.refine is False
    for given in ({"evaluations": 100}, {"algorithm": "nsga2"}, {"parameters": {"n_walkers": 1}}):
        assert configuration(**given) == (0, False)
    advice |= {"evaluations": 320}
    assert (
        prepare_run("cantilever", initial_designs=None, refine=None).configuration.evaluations
        == 320
    )
    assert (
        prepare_run("cantilever", initial_designs=None, refine=False).configuration.evaluations
        > 320
    )
