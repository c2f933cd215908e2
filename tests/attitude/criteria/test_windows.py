"""Time windows that must contain a whole plan."""

import numpy as np
import pytest
from mgeo_attitude import AttitudeManeuverProblem, Scenario
from mgeo_attitude.plan import ManeuverPlan
from mgeo_attitude.settings.errors import InvalidValue

OPEN = {"start": "2018-06-04T23:50:00Z", "end": "2018-06-05T00:12:30Z"}
LATER = {"start": "2018-06-05T06:00:00Z", "end": "2018-06-05T07:00:00+00:00"}
DESIGN = (0.5, 0.3, -0.2, 100.0, -0.3, 0.6, 0.2, 100.0, 0.2, -0.4, 0.7, 100.0)


def scenario(windows=(OPEN, LATER), **changed):
    table = {"preset": "paper", "duration": 900.0, "convergence": {"window": 60.0}}
    return Scenario.from_dict(table | {"windows": list(windows)} | changed)


def test_open_window_constrains_end_of_plan():
    problem = AttitudeManeuverProblem(scenario())
    assert problem.scenario.deadline == 750.0
    assert problem.constraint_names == ("end of the plan",)
    X = np.array([DESIGN, np.tile([0.9, -0.8, 0.7, 290.0], 3)])
    F, G = problem.evaluate(X, return_values_of=["F", "G"])
    np.testing.assert_allclose(G[:, 0], F[:, 0] / 750.0 - 1.0, rtol=1e-12, atol=1e-12)
    assert G.min() < 0.0 < G.max()


@pytest.mark.slow
def test_slew_back_must_end_before_window_closes():
    """The slew back is included in the constraint table of the plan, but not in the search."""
    table = {"maneuvers": {"slew_back": True}}
    plan = ManeuverPlan(scenario([OPEN | {"end": "2018-06-05T00:08:00Z"}], **table), DESIGN)
    rows = plan.build_constraint_table()
    assert rows.loc["end of the plan", "satisfied"] == (plan.t_end <= 480.0)
    complete = rows.loc["end of the plan, including hold and slew back"]
    assert complete["value"] == plan.duration > plan.t_end
    assert complete["satisfied"] == (plan.duration <= 480.0)


@pytest.mark.parametrize(
    ("windows", "key", "words"),
    [
        ([LATER], "epoch", "a start in one of the windows, 2018-06-05T06:00:00Z"),
        ([OPEN | {"start": "2018-06-04T23:50:00"}], "windows[0].start", "a UTC offset"),
    ],
)
def test_scenario_without_usable_window_is_rejected(windows, key, words):
    with pytest.raises(InvalidValue) as refused:
        scenario(windows)
    assert str(refused.value).startswith(key)
    assert words in str(refused.value)


def test_rule_end_allows_window_shorter_than_convergence_window():
    ended = {"rule": "end", "window": 60.0}
    half_a_minute = OPEN | {"end": "2018-06-05T00:00:30Z"}
    assert scenario([half_a_minute], convergence=ended).deadline == 30.0
    with pytest.raises(InvalidValue, match=r"1 s or more after the epoch, a step and"):
        scenario([OPEN | {"end": "2018-06-05T00:00:00.5Z"}], convergence=ended)
