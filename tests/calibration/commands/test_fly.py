"""``mgeo attitude fly``: files with telemetry and truth from both simulators."""

import dataclasses
import json
import re

import numpy as np
import pytest
from mgeo_attitude import Scenario
from mgeo_attitude.plan import ManeuverPlan, write_plan
from mgeo_attitude.scenario import Convergence
from mgeo_calibration.calibration.calibrate import calibrate
from mgeo_calibration.simulators.kinematic import simulate_telemetry
from mgeo_calibration.simulators.plan_comparison import END_ERROR, compare_with_plan
from mgeo_calibration.telemetry.reading import read_telemetry

from mgeo._text import format_number


@pytest.fixture(scope="module")
def plan(tmp_path_factory):
    """A plan and its file."""
    scenario = dataclasses.replace(
        Scenario.paper(), duration=600.0, convergence=Convergence(window=300.0)
    )
    found = ManeuverPlan(
        scenario, (0.5, 0.3, -0.2, 150.0, -0.3, 0.6, 0.2, 150.0, 0.2, -0.4, 0.7, 9)
    )
    path = tmp_path_factory.mktemp("plans") / "plan.json"
    write_plan(found, path)
    return found, path


def test_telemetry_equals_python_result_and_truth_has_calibration_keys(run, plan, tmp_path):
    found, path = plan
    out, truth = tmp_path / "telemetry.csv", tmp_path / "truth.json"
    text = run("fly", path, "--seed", 3, "--out", out, "--truth", truth).stdout
    assert "601 samples" in text
    assert "600 of mag" in text
    assert f"mgeo attitude calibrate {out} --plan {path}\n" in text
    assert "constraint" not in text  # The scenario has none.
    assert str(truth) in text
    expected = simulate_telemetry(found.scenario, found, 3)
    off = compare_with_plan(found, expected).loc[END_ERROR, "simulated"]
    assert re.search(rf"\n{END_ERROR} +deg +0 +{format_number(off)}\n", text)
    read = read_telemetry(out, found.scenario)
    np.testing.assert_array_equal(read.gyro_deg_s, expected.gyro_deg_s[-len(read.times) :])
    document = json.loads(truth.read_text())
    assert document["states"]["mag.bias"] == expected.truth.states[-1, 15:18].tolist()
    calibration = calibrate(found.scenario, read)
    table, rows = calibration.build_table(), document["parameters"]
    for key in ("block", "axis", "unit"):
        assert [row[key] for row in rows] == table[key].tolist()
    errors = np.array([row["value"] for row in rows]) - table["estimate"]
    assert (np.abs(errors) < 4.5 * table["sigma"]).all()
    assert abs(np.dot(document["quaternion"], calibration.quaternion)) > 0.999


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (
            ("--simulator", "simulink"),
            "simulink: expected one of 'kinematic', 'basilisk'",
        ),
        (("--vehicle", "paper"), "--vehicle: expected only with --simulator basilisk"),
        (("--truth", "truth.csv"), "truth.csv: expected a name that ends in .json"),
    ],
)
def test_invalid_input_prints_one_line_and_writes_nothing(
    run, plan, tmp_path, monkeypatch, arguments, expected
):
    monkeypatch.chdir(tmp_path)
    error = run("fly", plan[1], *arguments, code=2).stderr
    assert error.startswith("Error: ")
    assert error.count("\n") == 1
    assert expected in error
    assert not list(tmp_path.iterdir())


def test_missing_basilisk_prints_installation_command(run, plan, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    error = run("fly", plan[1], "--simulator", "basilisk", code=2).stderr
    assert error == ("Error: the simulator basilisk needs the package bsk: pip install bsk\n")
    assert not list(tmp_path.iterdir())
