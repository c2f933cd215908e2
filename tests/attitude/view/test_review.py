"""A plan as a document for a review, against what the plan itself tells."""

import dataclasses
from datetime import timedelta

import numpy as np
import pytest
from mgeo_attitude import AttitudeManeuverProblem, Scenario
from mgeo_attitude.plan import ManeuverPlan

from mgeo import View
from mgeo.plugins.shown import cells, kinds_of

DESIGN = (0.4, -0.2, 0.1, 300.0, 0.3, 0.5, -0.4, 200.0, -0.6, 0.1, 0.2, 100.0)


@pytest.fixture(scope="module")
def plan():
    scenario = dataclasses.replace(
        Scenario.paper(),
        name="ARGUS <1>",
        duration=2400.0,
        step=4.0,
        required_sigma={"attitude_deg": 2.0},
        convergence=dataclasses.replace(Scenario.paper().convergence, rule="end"),
    )
    return ManeuverPlan(scenario, DESIGN)


@pytest.fixture(scope="module")
def review(plan):
    return plan.view.review()


def section(review, start):
    (found,) = (each for each in review.sections if each.title.startswith(start))
    return found


def test_the_title_has_the_satellite_and_when_in_utc(plan, review):
    start = plan.scenario.epoch
    at = "%Y-%m-%dT%H:%M:%S"
    end = start + timedelta(seconds=plan.duration)
    assert review.title == (f"ARGUS <1>: calibration maneuvers, {start:{at}} to {end:{at}} UTC")
    assert review.answer == plan.answer


def test_the_timeline_says_what_each_command_buys(plan, review):
    table, told = section(review, "Timeline").table, plan.timeline().set_index("phase")
    assert list(table.index) == list(told.index)
    assert list(table["start UTC"]) == [t.removesuffix(".000000") for t in told["start UTC"]]
    for axis in "xyz":
        np.testing.assert_array_equal(table[f"{axis} [deg/s]"], told[f"rate {axis} [deg/s]"])
    bought = plan.contributions().iloc[1:]
    np.testing.assert_allclose(table["bought [%]"], bought["contribution [%]"])
    axes = [name for name in bought.columns if name.startswith("attitude ")]
    np.testing.assert_allclose(table["then attitude [deg]"], bought[axes].max(axis=1))


def test_what_coils_are_still_turning_at_the_end_has_bought_nothing_that_is_told():
    """A plan is flown for late flights, here those whose last maneuver takes longer."""
    late = {"count": 2, "duration_error": 30.0}
    scenario = {"preset": "cubesat_1u", "duration": 1200.0, "flight": late}
    scenario |= {"convergence": {"rule": "end", "window": 120.0}, "maneuvers": {"count": 2}}
    problem = AttitudeManeuverProblem(Scenario.from_dict(scenario))
    design = [0.0, 0.1, 0.0, 300.0, 2.0, -2.0, 1.0, 30.0]
    view = problem.view([design])
    assert view.held_until[0] > view.exactly.t_end[0] == 330.0
    table = section(view.review(), "Timeline").table
    *before, last = table.index
    assert last == "ramp to maneuver 2, for late flights"
    assert table.loc[before, "bought [%]"].notna().all()
    assert np.isnan(table.loc[last, "bought [%]"])


def test_budget_alternatives_and_sensors_are_those_of_the_plan(plan, review):
    why = section(review, "Why")
    np.testing.assert_allclose(why.table, plan.budget())
    assert why.lines == tuple(plan.reasons())
    beside = section(review, "Beside plans").table
    np.testing.assert_allclose(beside.T, plan.compare())
    assert list(beside.columns)[:2] == ["this plan", "no maneuver"]
    use = section(review, "How long").table
    np.testing.assert_array_equal(use, plan.sensor_use())
    instruments = section(review, "Gyro").table
    assert instruments.loc["sun", "noise"] == "noise 2 deg"
    assert "misalignment 1 deg" in instruments.loc["sun", "errors at the start, 1-sigma"]
    limits = section(review, "Limits").table
    np.testing.assert_allclose(limits["margin"], plan.constraints()["margin"])


def test_tables_as_text(review):
    rows = cells(section(review, "Timeline").table)
    assert rows[0][:2] == ["phase", "start UTC"]
    assert kinds_of(rows)[:3] == ["text", "text", "number"]
    assert all(len(row) == len(rows[0]) for row in rows)


def test_a_problem_without_a_review_of_its_own_has_its_description_and_limits(plan):
    found = View(plan.problem, [DESIGN]).review()
    assert [each.title for each in found.sections] == ["Solution", "Limits"]
    assert found.title == AttitudeManeuverProblem.__name__
