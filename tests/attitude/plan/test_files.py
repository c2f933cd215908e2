"""Files of plans: JSON round trips, invalid JSON, and CSV in full precision."""

import dataclasses
import json

import pandas as pd
import pytest
from mgeo_attitude.export_formats import FORMATS
from mgeo_attitude.plan import ManeuverPlan, from_json, read_json, to_csv, to_json, write_plan

from .test_aem import build_ramped_plan


@pytest.fixture(scope="module")
def text(plan):
    return to_json(plan)


@pytest.mark.parametrize("file", FORMATS, ids=lambda each: each.suffix)
def test_suffix_selects_format(plan, file, tmp_path):
    if file.package:
        pytest.importorskip(file.package)
    path = tmp_path / f"plan{file.suffix}"
    options = {"spacing": 100.0, "creation_time": plan.scenario.epoch}
    write_plan(plan, path, **options)
    content = file.load()(
        plan, **{key: options[key] for key in file.list_options() if key in options}
    )
    expected = content.encode() if isinstance(content, str) else content
    assert path.read_bytes()[:2000] == expected[:2000]
    assert list(tmp_path.iterdir()) == [path]


def test_json_round_trip(plan, text, tmp_path):
    path = tmp_path / "plan.json"
    write_plan(plan, path)
    back = read_json(path)
    assert back == plan
    assert to_json(back) == text == path.read_text(encoding="utf-8")
    other = dataclasses.replace(plan.scenario, name="another")
    assert from_json(to_json(ManeuverPlan(other, plan.design))) != plan


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda t: t.update(format="plan"), "format = 'plan'"),
        (lambda t: t["design"].__setitem__(0, 60.0), r"design\[0\] = 60\.0: expected -1 to 1"),
        (
            lambda t: t["scenario"]["orbit"].update(eccentricity=1.2),
            r"scenario\.orbit\.eccentricity = 1\.2",
        ),
        (
            lambda t: t.update(scenario={"preset": "cubesat_6u", "maneuvers": {"count": 3}}),
            r"scenario\.preset = 'cubesat_6u': expected all keys",
        ),
    ],
)
def test_invalid_entry_is_rejected_with_its_key(text, change, message, tmp_path):
    path, table = tmp_path / "touched.json", json.loads(text)
    change(table)
    path.write_text(json.dumps(table), encoding="utf-8")
    with pytest.raises(ValueError, match=message) as error:
        read_json(path)
    assert str(path) in str(error.value)


@pytest.mark.parametrize(
    ("content", "message"),
    [(b"", "Expecting value"), (b"\xff\xfe{}", "utf-8")],
)
def test_file_without_plan_is_rejected(content, message, tmp_path):
    path = tmp_path / "no-plan.json"
    path.write_bytes(content)
    with pytest.raises(ValueError, match=rf"no-plan\.json: .*{message}"):
        read_json(path)


@pytest.mark.parametrize("ramps", [False, True])
def test_csv_has_timeline_in_full_precision(ramps, plan, problem, tmp_path):
    plan = build_ramped_plan(problem) if ramps else plan
    path = tmp_path / "plan.csv"
    path.write_text(to_csv(plan), encoding="utf-8")
    table = pd.read_csv(path, dtype=str)
    n = len(plan.phases)
    assert table.pop("row").tolist() == [f"{i}/{n}" for i in range(1, n + 1)]
    expected = plan.build_timeline()
    pd.testing.assert_frame_equal(table.astype(expected.dtypes), expected, check_exact=True)
    assert ("ramp to maneuver 1" in set(table["phase"])) == ramps
