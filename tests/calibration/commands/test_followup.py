"""Follow-up plans: ``mgeo solve attitude --after`` and ``mgeo attitude fly --after``."""

import json
from pathlib import Path

import numpy as np
import pytest
from mgeo_attitude import Scenario
from mgeo_attitude.plan import ManeuverPlan, read_front, write_plan
from mgeo_calibration.calibration.document import read_json
from typer.testing import CliRunner

from mgeo.cli.app import app

from ..calibration.runs import PLAN, short


@pytest.fixture(scope="module")
def flown(tmp_path_factory):
    """Folder with a plan that is simulated for its first maneuver, and its calibration."""
    folder = tmp_path_factory.mktemp("first")
    scenario = short(Scenario.cubesat_6u(), 1500.0)
    write_plan(ManeuverPlan(scenario, PLAN), folder / "plan.json")
    for line in (
        "attitude fly plan.json --until 400 --out telemetry.csv --truth truth.json",
        "attitude calibrate telemetry.csv --plan plan.json --out calibration",
    ):
        words = [str(folder / w) if (folder / w).suffix or w == "calibration" else w
                 for w in line.split()]  # fmt: skip
        done = CliRunner().invoke(app, words, prog_name="mgeo")
        assert done.exit_code == 0, done.output + done.stderr
    return folder


def solve(*words, code=0):
    done = CliRunner().invoke(app, ["solve", "attitude", *map(str, words)], prog_name="mgeo")
    assert done.exit_code == code, done.output + done.stderr
    return done


@pytest.mark.slow
def test_followup_plan_is_solved_simulated_and_calibrated(run, flown, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("rest.toml").write_text("duration = 1200.0\nmaneuvers.count = 2\n")
    calibration = flown / "calibration" / "calibration.json"
    solve(
        "--after", calibration, "--scenario", "rest.toml", "--evaluations", 160, "--out", "r", "-q"
    )
    front, found = read_front("r"), read_json(calibration)
    assert front.problem.n_var == 8
    expected = found.build_followup_scenario({"duration": 1200.0, "maneuvers": {"count": 2}})
    assert front.problem.scenario == expected
    assert found.time == 400.0
    run("export", "r", "second.json", "--pick", "min-trace")
    run(
        "fly", "second.json", "--after", flown / "truth.json", "--out", "2.csv", "--truth", "2.json"
    )
    before, after = (json.loads(p.read_text()) for p in (flown / "truth.json", Path("2.json")))
    for block in ("sun.misalignment", "sun.bias", "mag.bias"):
        assert before["states"][block] == after["states"][block]
    text = run("calibrate", "2.csv", "--plan", "second.json", "--out", "c", "--json").stdout
    document = json.loads(text)
    assert document["is_consistent"]
    x = np.array(
        [
            (row["value"] - one["estimate"]) / one["sigma"]
            for row, one in zip(after["parameters"], document["parameters"], strict=True)
        ]
    )
    assert np.abs(x).max() < 4.2
    sigma = [row["sigma"] for row in document["parameters"]]
    assert (np.array(sigma)[3:] < found.build_table()["sigma"].to_numpy()[3:]).all()
    assert {p.name for p in Path("c").iterdir()} >= {"calibration.json", "calibration.html"}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            {"time_s": 300.0},
            "truth.json: time_s = 300.0: expected the epoch of the plan, 400.000000",
        ),
        ({"states": {}}, "truth.json: states = []: expected gyro.bias"),
    ],
)
def test_truth_of_another_run_prints_one_line(run, flown, tmp_path, monkeypatch, change, message):
    monkeypatch.chdir(tmp_path)
    document = json.loads((flown / "truth.json").read_text()) | change
    Path("truth.json").write_text(json.dumps(document))
    found = read_json(flown / "calibration" / "calibration.json")
    plan = ManeuverPlan(found.build_followup_scenario({"duration": 600.0}), PLAN)
    write_plan(plan, "second.json")
    error = run("fly", "second.json", "--after", "truth.json", code=2).stderr
    assert error.count("\n") == 1
    assert message in error
    assert not Path("telemetry.csv").exists()
