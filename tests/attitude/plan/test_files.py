"""JSON that reads back exactly, JSON that somebody has touched, and CSV that has every digit."""

import dataclasses
import json
from pathlib import Path
from pkgutil import resolve_name

import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mgeo_attitude import AttitudeManeuverProblem
from mgeo_attitude.plan import (
    ManeuverPlan,
    from_json,
    read_json,
    to_csv,
    to_json,
    write_plan,
)

from ..scenario.strategies import scenarios
from .conftest import DESIGN

REFERENCE = Path(__file__).parents[1] / "reference"


@pytest.fixture(scope="module")
def text(plan):
    return to_json(plan)


def test_round_trip(plan, text, tmp_path):
    path = tmp_path / "plan.json"
    write_plan(plan, path)
    back = read_json(path)
    assert back == plan
    assert to_json(back) == text == path.read_text(encoding="utf-8")
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.slow
@settings(deadline=None, max_examples=12)
@given(scenarios(), st.integers(1, 5), st.data())
def test_any_scenario_and_design_round_trip(scenario, count, data):
    """Without what follows from them, which takes a second each."""
    # no orbit above the surface turns faster, nor do starts that are drawn
    rate = max(scenario.maneuvers.max_rate_deg_s, 0.2)
    maneuvers = dataclasses.replace(scenario.maneuvers, max_rate_deg_s=rate)
    scenario = dataclasses.replace(scenario, maneuvers=maneuvers)
    problem = AttitudeManeuverProblem(scenario, n_maneuvers=count)
    bounds = zip(problem.xl, problem.xu, strict=True)
    design = data.draw(st.tuples(*(st.floats(low, high) for low, high in bounds)))
    plan = ManeuverPlan(problem.scenario, design)
    brief = dataclasses.replace(
        resolve_name(FORM), consequences=lambda _: {k: [] for k in CONSEQUENCES}
    )
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(FORM, brief)
        assert from_json(to_json(plan)) == plan


FORM = "mgeo_attitude.plan.files._FORM"
CONSEQUENCES = ("predicted", "constraints", "timeline", "accuracy")


def edited(text, change):
    table = json.loads(text)
    change(table)
    return json.dumps(table)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda t: t.update(format="plan"), "format = 'plan'"),
        (lambda t: t.update(version=1), "version = 1: this package reads version 2 or 3"),
        (lambda t: t.update(version=True), "version = True"),
        (lambda t: t.update(note=""), "note = ''"),
        (lambda t: t.pop("timeline"), "timeline is missing"),
        (lambda t: t.update(design="x"), "design = 'x'"),
        (lambda t: t["design"].pop(), "design = .* expected 12 numbers"),
        (lambda t: t["design"].__setitem__(0, 0.6), r"predicted\.t|predicted"),
        (lambda t: t["design"].__setitem__(0, None), r"design\[0\] = None"),
        (
            lambda t: t["scenario"]["orbit"].update(eccentricity=1.2),
            r"orbit\.eccentricity = 1\.2",
        ),
        (
            lambda t: t["scenario"]["maneuvers"].update(count=10**9),
            r"scenario\.maneuvers\.count",
        ),
        (
            lambda t: t["scenario"].update(duration=2e6, step=1.0),
            r"scenario\.duration = 2000000\.0: expected at most 1000000 times step = 1\.0 s",
        ),
        (lambda t: t["scenario"].update(orbits=1), "orbits"),
        (
            lambda t: t.update(scenario={"preset": "cubesat_6u", "maneuvers": {"count": 3}}),
            r"scenario\.preset = 'cubesat_6u': expected all keys",
        ),
        (lambda t: t["predicted"].update({"t_end [s]": 1.0}), r"predicted\.t_end \[s\] = 1\.0"),
        (lambda t: t["predicted"].update(converged=1), r"predicted\.converged = 1"),
        (lambda t: t["constraints"].append({}), r"constraints = \[\{\}\]"),
        (lambda t: t["timeline"][1].update({"rate x [deg/s]": 0.4}), r"timeline\[1\]\.rate x"),
        (lambda t: t["timeline"][0].update({"start UTC": "now"}), r"timeline\[0\]\.start UTC"),
        (lambda t: t["timeline"].pop(), r"timeline = "),
        (lambda t: t["accuracy"][3].update(after=10**400), r"accuracy\[3\]\.after"),
        (lambda t: t["accuracy"][3].pop("unit"), r"accuracy\[3\]"),
    ],
)
def test_what_was_changed_is_named(text, change, message, tmp_path):
    path = tmp_path / "touched.json"
    path.write_text(edited(text, change), encoding="utf-8")
    with pytest.raises(ValueError, match=message) as error:
        read_json(path)
    assert str(path) in str(error.value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "Expecting value"),
        ("[1]", "format = None"),
        ("[" * 100_000, "nested too deeply"),
        ('{"format": NaN}', "NaN is no finite number"),
    ],
)
def test_what_is_no_json_of_ours(text, message):
    with pytest.raises(ValueError, match=message):
        from_json(text)


@settings(deadline=None, max_examples=60)
@given(st.data())
def test_truncated_anywhere_it_is_refused(text, data):
    cut = data.draw(st.integers(0, len(text) - 3))  # the last two are the brace and the line's end
    with pytest.raises(ValueError):  # noqa: PT011 - which message depends on the place
        from_json(text[:cut])


@settings(deadline=None, max_examples=25)
@given(st.integers(0, 10**9), st.sampled_from('0123456789.-eE"{}[],: N\n\x00é'))
def test_one_character_changed_makes_another_plan_or_a_clear_error(text, plan, place, character):
    """Nothing but ValueError and TypeError comes out, and no plan that contradicts itself."""
    place %= len(text)
    touched = text[:place] + character + text[place + 1 :]
    try:
        found = from_json(touched)
    except (ValueError, TypeError):
        return
    assert from_json(to_json(found)) == found


def test_other_bytes_and_huge_files(tmp_path, monkeypatch):
    path = tmp_path / "bytes.json"
    path.write_bytes(b"\xff\xfe{}")
    with pytest.raises(ValueError, match=r"bytes\.json"):
        read_json(path)
    monkeypatch.setattr("mgeo_attitude.plan.documents.MOST_BYTES", 2)
    with pytest.raises(ValueError, match="has 4 bytes: expected at most 2"):
        read_json(path)
    with pytest.raises(FileNotFoundError):
        read_json(tmp_path / "none.json")


@pytest.mark.slow
def test_a_plan_of_an_older_version_is_read_and_computed_anew():
    """Written with mgeo-attitude 0.1.0 of 2026-11-24, whose predictions are others in part."""
    path = REFERENCE / "plan-version-2.json"
    said = json.loads(path.read_text(encoding="utf-8"))
    assert said["version"] == 2
    plan = read_json(path)
    assert list(plan.design) == said["design"]
    assert plan.t_end == said["predicted"]["t_end [s]"]
    assert plan.trace == pytest.approx(said["predicted"]["trace [-]"], rel=1e-9)
    assert plan.attitude_sigma_deg < said["predicted"]["attitude accuracy [deg]"]
    assert json.loads(to_json(plan))["version"] == 3
    assert from_json(to_json(plan)) == plan
    with pytest.raises(ValueError, match="attitude accuracy"):  # as if it were a new one
        from_json(json.dumps(said | {"version": 3}))


def test_numbers_that_other_libraries_round_otherwise_are_the_same(text, plan):
    table = json.loads(text)
    table["predicted"]["trace [-]"] *= 1.0 + 1e-10
    table["timeline"][0]["start q1"] += 1e-14
    table["timeline"][0]["end [s]"] = int(table["timeline"][0]["end [s]"])  # as JavaScript does
    assert from_json(json.dumps(table)) == plan


def test_scenarios_are_part_of_the_plan(plan, text):
    other = dataclasses.replace(plan.scenario, name="another")
    assert from_json(to_json(ManeuverPlan(other, plan.design))) != plan


@pytest.fixture(scope="module")
def ramped(problem):
    """A plan whose rates change along ramps."""
    maneuvers = dataclasses.replace(problem.scenario.maneuvers, max_acceleration_deg_s2=0.05)
    return ManeuverPlan(dataclasses.replace(problem.scenario, maneuvers=maneuvers), DESIGN)


@pytest.mark.parametrize("fixture", ["plan", "ramped"])
def test_the_file_has_the_timeline_to_the_last_digit(fixture, request, tmp_path):
    plan = request.getfixturevalue(fixture)
    path = tmp_path / "plan.csv"
    write_plan(plan, path)
    assert path.read_text(encoding="utf-8") == to_csv(plan)
    table = pd.read_csv(path, dtype=str)
    n = len(plan.phases)
    assert table.pop("row").tolist() == [f"{i}/{n}" for i in range(1, n + 1)]
    expected = plan.timeline()
    pd.testing.assert_frame_equal(table.astype(expected.dtypes), expected, check_exact=True)
    assert ("ramp to maneuver 1" in set(table["phase"])) == (fixture == "ramped")


def test_another_suffix_is_refused(plan, tmp_path):
    with pytest.raises(ValueError, match=r"plan\.txt: expected .* \.uplink\.csv, \.csv, \.aem"):
        write_plan(plan, tmp_path / "plan.txt")
    assert not list(tmp_path.iterdir())
