"""A start that is free: what is computed in one table is what each start is by itself."""

import numpy as np
import pytest
from mgeo_attitude import AttitudeManeuverProblem, FilterModel, Scenario, evaluate
from mgeo_attitude.bound.assembly import limit
from mgeo_attitude.plan import ManeuverPlan, from_json, to_json
from mgeo_attitude.settings.errors import InvalidValue

from mgeo.studies.fingerprint.parts import fingerprint

#: An orbit and its eclipse lie between the first start and the last.
FREE = {"latest_start": 5400.0, "start_interval": 600.0}


def scenario(preset="cubesat_6u", maneuvers=FREE, **changed):
    table = {"preset": preset, "duration": 600.0}
    table["convergence"] = {"rule": "trace", "window": 60.0}
    return Scenario.from_dict(table | {"maneuvers": {"count": 3} | maneuvers} | changed)


@pytest.fixture(scope="module")
def problem():
    return AttitudeManeuverProblem(scenario())


@pytest.fixture(scope="module")
def X(problem):
    rng = np.random.default_rng(3)
    return rng.uniform(problem.xl, problem.xu, (12, problem.n_var))


def values(problem, X):
    return problem.evaluate(X, return_values_of=["F"])


def test_the_start_is_the_last_variable(problem):
    assert problem.var_names[-1] == "start [s]"
    assert (problem.xl[-1], problem.xu[-1]) == (0.0, 5400.0)
    assert problem.start_times.times.tolist() == [600.0 * k for k in range(10)]


def test_a_batch_of_several_starts_gives_what_each_gives_alone(problem, X):
    F = values(problem, X)
    assert len(set(problem.start_times.split(X)[1])) > 4
    for x, found in zip(X, F, strict=True):
        own, maneuvers = problem.begun(x)
        assert values(own, maneuvers).tolist() == found.tolist()
    for threads in (1, 2):
        again = AttitudeManeuverProblem(problem.scenario, threads=threads)
        again.__dict__["start_times"] = problem.start_times
        np.testing.assert_array_equal(values(again, X[::-1]), F[::-1])


def test_problems_of_starts_that_it_remembers_are_no_part_of_it_nor_is_the_number_of_threads(X):
    new, used = (AttitudeManeuverProblem(scenario(), threads=threads) for threads in (1, 2))
    assert used.begun(X[0])[0] is used.begun(X[0])[0]
    assert fingerprint(new) == fingerprint(used)


def test_a_plan_is_one_of_the_scenario_that_begins_then(problem, X):
    """Its tables are computed anew, from its own epoch: of times that are rounded otherwise."""
    plan = ManeuverPlan.from_design(problem, X[0])
    start = problem.start_times.times[problem.start_times.split(X[0])[1][0]]
    assert (plan.scenario.epoch - problem.scenario.epoch).total_seconds() == start
    assert plan.scenario.maneuvers.latest_start is None
    (F,) = values(problem, X[:1])
    np.testing.assert_allclose([plan.t_end, plan.trace], F, rtol=1e-6)
    assert from_json(to_json(plan)) == plan
    with pytest.raises(InvalidValue, match=r"scenario\.maneuvers\.latest_start.*from_design"):
        ManeuverPlan(problem.scenario, plan.design)


@pytest.mark.cases(1)
@pytest.mark.parametrize(
    "changed",
    [
        {"initial": {"pointing": "nadir"}, "maneuvers": FREE | {"max_acceleration_deg_s2": 0.05}},
        {
            "initial": {"pointing": "nadir"},
            "wheels": {
                "inertia": [0.06, 0.08, 0.05],
                "max_momentum": 5e-3,
                "initial_momentum": [1e-3, 0.0, 0.0],
                "gravity_gradient": True,
            },
            "path_limits": [{"name": "camera", "boresight": [1.0, 0.0, 0.0], "half_angle_deg": 9}],
        },
        {"preset": "cubesat_1u"},
    ],
    ids=["ramps", "wheels and a path limit", "coils"],
)
def test_what_turns_it_begins_where_it_does(changed):
    problem = AttitudeManeuverProblem(scenario(**changed))
    rng = np.random.default_rng(4)
    X = rng.uniform(problem.xl, problem.xu, (6, problem.n_var))
    found = problem.evaluate(X, return_values_of=["F", "G"])
    for x, *expected in zip(X, *found, strict=True):
        own, maneuvers = problem.begun(x)
        model = FilterModel.from_scenario(own.scenario)  # by itself
        assert np.abs(model.initial_attitude - own.model.initial_attitude).max() < 1e-9
        fresh = own.valued(model, evaluate(model, maneuvers, 1))[0]
        for one, other in zip((fresh[:2], fresh[2 : 2 + own.n_ieq_constr]), expected, strict=True):
            np.testing.assert_allclose(one, other, rtol=1e-6, atol=1e-9)


def test_the_limit_is_the_least_of_all_starts(problem, X):
    found = problem.limit_curves
    alone = []
    for number, time in enumerate(problem.start_times.times):
        own = problem.scenario.starting(float(time))
        alone.append(limit(own, problem.start_times.at(number)))
    for name in ("trace", "ending"):
        least = np.min([getattr(each, name) for each in alone], axis=0)
        np.testing.assert_allclose(getattr(found, name), least, rtol=1e-12)
    np.testing.assert_allclose(
        found.worst["mag.bias"], np.min([each.worst["mag.bias"] for each in alone], axis=0)
    )
    F = values(problem, X)
    assert (F[:, 1] > found.at(F[:, 0])).all()
    assert found.given_away[0].startswith("the start")
    assert alone[0].trace[-1] > 1.001 * found.trace[-1]


@pytest.mark.slow
def test_flights_are_those_of_the_start(X):
    """A delay is of whole sets of samples there, and exact in the plan's own flights."""
    flight = {"count": 4, "start_delay": 100.0, "noise_spread": 0.1}
    robust = AttitudeManeuverProblem(scenario(flight=flight))
    F = values(robust, X[:3])
    exact = values(AttitudeManeuverProblem(scenario()), X[:3])
    for x, found in zip(X[:3], F, strict=True):
        own, maneuvers = robust.begun(x)
        np.testing.assert_allclose(values(own, maneuvers), found, rtol=0.01)
    assert np.abs(F / exact - 1.0).max() > 0.02


@pytest.mark.slow
def test_good_starts_and_a_polish_keep_to_the_start_times(problem):
    X = problem.starts(4, np.random.default_rng(1))
    assert set(X[:, -1]) <= set(problem.start_times.times)
    *_, better = problem.refine(X)
    assert len(better) > len(X)  # then come others, at times between them
    before, after = values(problem, X), values(problem, better[: len(X)])
    assert (after <= before).all()
    assert (after[:, 1] < before[:, 1]).any()
    assert (problem.xl <= better).all()
    assert (better <= problem.xu).all()


@pytest.mark.slow
def test_a_view_tells_when_each_plan_begins(problem, X):
    view = problem.view(X[:2])
    table = view.describe()
    for text, x in zip(table["start UTC"], X, strict=False):
        assert text.startswith(problem.begun(x)[0].scenario.epoch.strftime("%Y-%m-%dT%H:%M:%S"))
    assert len(view.answers()) == len(view.solution_figures()) == 2


WINDOWS = [
    {"start": "2018-06-05T00:28:00Z", "end": "2018-06-05T00:45:00Z"},
    {"start": "2018-06-05T01:18:00Z", "end": "2018-06-05T01:23:00Z"},
]


def test_a_plan_begins_and_is_over_in_a_window():
    problem = AttitudeManeuverProblem(scenario(windows=WINDOWS))
    assert problem.start_times.times.tolist() == [1800.0, 2400.0, 4800.0]
    x = np.append(np.tile([0.5, 0.2, -0.1, 150.0], 3), 2400.0)
    G = problem.evaluate(x, return_values_of=["G"])
    end = problem.evaluate(x, return_values_of=["F"])[0]
    assert G.tolist() == pytest.approx([end / 300.0 - 1.0])
    (row,) = problem.view([x]).limits()
    assert row.loc["end of the plan", "limit"] == 300.0
    assert row.loc["end of the plan", "margin"] == pytest.approx(300.0 - end)


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"maneuvers": {"start_interval": 60.0}}, r"maneuvers\.start_interval = 60.*latest_start"),
        ({"maneuvers": {"latest_start": 9e3, "start_interval": 0.5}}, r"multiple of 1\.0 s"),
        (
            {"maneuvers": {"latest_start": 9e4, "start_interval": 1.0}},
            r"maneuvers\.start_interval = 1.*at least 45\.02 s",
        ),
        (
            {"maneuvers": FREE, "channels": [{"name": "temp", "times": [0.0], "values": [20.0]}]},
            r"maneuvers\.latest_start = 5400\.0: expected none beside \[\[channels",
        ),
        ({"maneuvers": {"latest_start": 2e6}}, r"maneuvers\.latest_start.*at most 1000000 times"),
        (
            {"maneuvers": FREE, "flight": {"start_delay": 2e6}},
            r"maneuvers\.latest_start.*duration and flight\.start_delay at most 1000000 times",
        ),
        ({"windows": WINDOWS, "maneuvers": {}}, r"epoch.*a start in one of the windows, 2018"),
        (
            {"windows": WINDOWS, "maneuvers": FREE | {"latest_start": 600.0}},
            r"maneuvers\.latest_start = 600.*one of the windows",
        ),
        (
            {"windows": [{"start": "2018-06-05T00:10:00Z", "end": "2018-06-05T00:10:30Z"}]},
            r"windows\[0\]\.end.*60 s or more after the first start in it",
        ),
    ],
)
def test_starts_that_contradict_other_keys_are_refused(changed, words):
    with pytest.raises(InvalidValue, match=words):
        scenario(**changed)
