"""Runs with suggested initial designs and with local refinement."""

import numpy as np
import pytest

from mgeo import read_record
from mgeo.plugins.problems import load_problem
from mgeo.runs.prepare import PreparedRun, prepare_run, resume_run

pytestmark = pytest.mark.usefixtures("stand_in")
SMALL_PARAMETERS = {"n_walkers": 4}


def prepare(initial_designs=0, refine=False, **options):
    options = {"parameters": SMALL_PARAMETERS, "evaluations": 160, "seed": 2} | options
    return prepare_run("cantilever", initial_designs=initial_designs, refine=refine, **options)


def test_refined_designs_replace_front():
    search, outcome = prepare().solve(), prepare(refine=True).solve()
    assert outcome.n_evaluations == search.n_evaluations
    assert (search.n_refined, outcome.n_refined) == (0, (search.X[:, 1] > 0.2).sum())
    assert (outcome.X[:, 1] == 0.2).all()
    F = load_problem("cantilever").evaluate(outcome.X)
    np.testing.assert_array_equal(F, outcome.F)
    for before in search.F:
        assert (before >= outcome.F).all(axis=1).any()
    assert outcome.hypervolume > search.hypervolume


def test_suggested_designs_are_evaluated_first(tmp_path):
    run = prepare(initial_designs=3, record=True)
    outcome = run.solve(folder=tmp_path)
    record = read_record(tmp_path / "evaluations")
    assert len(record) == outcome.n_evaluations
    np.testing.assert_allclose(record["length [m]"][:3], 0.2)
    assert record["generation"][2] == 1
    repeated = PreparedRun.from_configuration(run.configuration).solve()
    np.testing.assert_array_equal(repeated.F, outcome.F)


class KillSignal(BaseException):
    pass


@pytest.mark.parametrize("step", [0, 5])
def test_run_killed_during_refinement_equals_uninterrupted_run(step, tmp_path):
    run = prepare(refine=True)
    steps = []

    def kill(state):
        if state.refinement is not None:
            steps.append(state.n_evaluations)
            if len(steps) > step:
                raise KillSignal

    with pytest.raises(KillSignal):
        run.solve(kill, tmp_path)
    expected, resumed = prepare(refine=True).solve(), resume_run(tmp_path)
    assert resumed.configuration == run.configuration
    outcome = resumed.solve()
    np.testing.assert_array_equal(outcome.X, expected.X)
    assert (outcome.n_refined, outcome.stop_reason) == (expected.n_refined, "budget")


def replace_refinement(monkeypatch, method):
    monkeypatch.setattr(type(load_problem("cantilever")), "refine", method)


def lengthen(self, X):
    yield X + np.array([0.0, 0.01])


def append_designs(self, X):
    """Append a design twice: first an invalid one, then better ones."""
    if len(X):
        more = np.array([[X[:, 0].min() * 0.5, 0.2], [X[:, 0].min() * 0.7, 0.2]])
        yield np.vstack([X, more[:1]])
        yield np.vstack([X, more])
        yield np.vstack([X + np.array([0.0, 0.01]), more * np.array([1.0, 1.1])])


def improve_and_fail(self, X):
    if len(X):
        better = X.copy()
        better[X[:, 1].argmax(), 1] = 0.2
        yield better
        raise RuntimeError("no more")


@pytest.mark.parametrize(
    ("method", "message"),
    [
        (lengthen, ""),
        (improve_and_fail, "refine of problem Cantilever raised RuntimeError: no more"),
    ],
)
def test_failed_or_worse_refinement_keeps_the_front(method, message, monkeypatch):
    search = prepare().solve()
    replace_refinement(monkeypatch, method)
    outcome = prepare(refine=True).solve()
    assert message in outcome.refinement_error
    assert bool(outcome.refinement_error) == bool(message)
    assert outcome.n_refined == (method is improve_and_fail)
    assert outcome.stop_reason == "budget"
    rows_of_search = {tuple(row) for row in search.X}
    assert len([row for row in outcome.X if tuple(row) in rows_of_search]) >= len(outcome.X) - 1


def test_designs_beyond_the_front_are_added(monkeypatch):
    search = prepare().solve()
    replace_refinement(monkeypatch, append_designs)
    run, sizes = prepare(refine=True), []

    def record_size(state):
        if state.refinement is not None:
            sizes.append(len(state.refinement.solutions))

    outcome = run.solve(record_size)
    assert (outcome.n_refined, outcome.n_added) == (0, 2)
    n = len(search.X)
    assert sizes[:3] == [n + 1, n + 2, n + 2]
    added = search.X[:, 0].min() * np.array([0.5, 0.7])
    for diameter in added:
        assert [diameter, 0.2] in outcome.X.tolist()
    F = load_problem("cantilever").evaluate(outcome.X)
    np.testing.assert_array_equal(F, outcome.F)
    assert outcome.hypervolume >= search.hypervolume


def test_unsupported_settings_are_rejected_before_the_search(monkeypatch):
    def reject_problem(self, X):
        raise ValueError("two objectives only")

    replace_refinement(monkeypatch, reject_problem)
    with pytest.raises(ValueError, match="refine of problem Cantilever raised ValueError: two"):
        prepare(refine=True)
    monkeypatch.delattr(type(load_problem("cantilever")), "refine")
    with pytest.raises(ValueError, match=r"problem Cantilever has no refine\(\)"):
        prepare(refine=True)
    with pytest.raises(
        ValueError, match=r"initial_designs = 5: expected at most 4, the number of walkers"
    ):
        prepare(initial_designs=5)
    with pytest.raises(
        ValueError, match="initial_designs = 1: RandomSearch accepts no initial designs"
    ):
        prepare(initial_designs=1, algorithm="random", parameters={})
    monkeypatch.delattr(type(load_problem("cantilever")), "suggest_initial_designs")
    with pytest.raises(ValueError, match=r"Cantilever has no suggest_initial_designs\(\)"):
        prepare(initial_designs=1)


def test_recommended_settings_apply_without_other_settings(monkeypatch):
    def configuration(**options):
        run_configuration = prepare_run(
            "cantilever", **({"initial_designs": None, "refine": None} | options)
        ).configuration
        return run_configuration.initial_designs, run_configuration.refine

    assert configuration() == (0, False)
    problem_class = type(load_problem("cantilever"))
    recommended = {"initial_designs": 2, "refine": True}
    monkeypatch.setattr(
        problem_class, "recommend_settings", lambda self: recommended, raising=False
    )
    assert configuration() == (2, True)
    assert configuration(initial_designs=0) == (0, True)
    assert configuration(refine=False) == (2, False)
    assert prepare_run("cantilever").configuration.refine is False
    for settings in (
        {"evaluations": 100},
        {"algorithm": "nsga2"},
        {"parameters": {"n_walkers": 1}},
    ):
        assert configuration(**settings) == (0, False)
    recommended |= {"evaluations": 320}
    assert (
        prepare_run("cantilever", initial_designs=None, refine=None).configuration.evaluations
        == 320
    )
    assert (
        prepare_run("cantilever", initial_designs=None, refine=False).configuration.evaluations
        > 320
    )
