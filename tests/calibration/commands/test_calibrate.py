"""``mgeo attitude calibrate``: output, files and error messages."""

import dataclasses
import json
import re
from datetime import timedelta

import jsonschema
import numpy as np
import pandas as pd
import pytest
from mgeo_attitude import Scenario
from mgeo_attitude.plan import ManeuverPlan, write_plan
from mgeo_calibration import calibrate
from mgeo_calibration.calibration.document import read_json
from mgeo_calibration.commands.calibrate import FILES

from mgeo.validation.documents import collect_documents

from ..calibration.runs import PLAN, short, simulate_from_any_attitude
from .screens import parse_table


@pytest.fixture(scope="module")
def flight(tmp_path_factory):
    """Folder with a plan, its scenario, and simulated telemetry."""
    folder = tmp_path_factory.mktemp("telemetry")
    scenario = short(Scenario.paper(), 900.0)
    scenario.save(folder / "mine.toml")
    write_plan(ManeuverPlan(scenario, PLAN), folder / "plan.json")
    telemetry = simulate_from_any_attitude(scenario, 3)
    telemetry.to_csv(folder / "telemetry.csv")
    return folder, scenario, telemetry


def test_output_files_include_comparison_with_plan(run, flight, tmp_path):
    folder, scenario, telemetry = flight
    out = tmp_path / "new" / "calibration"
    arguments = (
        "calibrate",
        folder / "telemetry.csv",
        "--plan",
        folder / "plan.json",
        "--out",
        out,
    )
    text = run(*arguments).stdout
    found = calibrate(scenario, telemetry)
    predicted = found.compare(ManeuverPlan(scenario, PLAN))
    printed = parse_table(text, "Predicted and achieved 1-sigma, worst axis")
    bias = predicted.loc[[f"mag bias {axis}" for axis in "xyz"]]
    expected = bias[["predicted", "achieved"]].max()
    np.testing.assert_allclose([float(cell) for cell in printed["mag bias"][1:3]], expected, 0.05)
    assert all(str(out / name) in text for name in FILES)
    assert sorted(path.name for path in out.iterdir()) == sorted(FILES)
    np.testing.assert_array_equal(read_json(out / "calibration.json").states, found.states)
    written = pd.read_csv(out / "calibration.csv", dtype=str)
    np.testing.assert_array_equal(
        written["estimate"].astype(float), found.build_table()["estimate"]
    )
    assert "Predicted and achieved 1-sigma" in (out / "calibration.html").read_text()
    assert "exists" in run(*arguments, code=2).stderr
    run(*arguments, "--overwrite", "--quiet")


def test_json_document_has_documented_keys(run, flight):
    folder, _, _ = flight
    found = json.loads(
        run("calibrate", folder / "telemetry.csv", "--plan", folder / "plan.json", "--json").stdout
    )
    jsonschema.validate(found, collect_documents()["attitude-calibrate"].build_schema())
    assert found["is_consistent"] is True
    assert found["failures"] == []
    assert len(found["predicted"]) == 18
    assert all(row["is_passed"] for row in found["tests"])
    (bias,) = (
        row for row in found["parameters"] if (row["block"], row["axis"]) == ("mag.bias", "x")
    )
    assert (bias["unit"], bias["unit_si"]) == ("nT", "T")
    assert bias["estimate_si"] == pytest.approx(1e-9 * bias["estimate"])


def test_inconsistent_calibration_exits_with_code_3(run, flight, tmp_path):
    folder, scenario, _ = flight
    quiet = dataclasses.replace(scenario.sensors[1], noise_nt=350.0)
    dataclasses.replace(scenario, sensors=(scenario.sensors[0], quiet)).save(tmp_path / "q.toml")
    done = run("calibrate", folder / "telemetry.csv", "--scenario", tmp_path / "q.toml", code=3)
    verdict = " ".join(done.stdout.partition("\n\n")[0].split())
    assert verdict.startswith('Statistically inconsistent: the test "noise of mag" failed (NIS ')
    assert "--fit noise" in verdict
    assert "not to be used" in done.stdout
    assert parse_table(done.stdout, "Tests")["noise of mag"][-1] == "FAILED"


def test_screen_has_verdict_parameters_and_tests_within_80_columns(run, flight, monkeypatch):
    folder, scenario, telemetry = flight
    monkeypatch.setenv("COLUMNS", "80")
    command = ("calibrate", folder / "telemetry.csv", "--plan", folder / "plan.json")
    summary, complete = run(*command).stdout, run(*command, "--all").stdout
    lines = summary.splitlines()
    assert "statistically consistent" in lines[0]
    assert len(lines) <= 55
    assert max(map(len, complete.splitlines())) <= 80
    found = calibrate(scenario, telemetry)
    printed = parse_table(summary, "Calibration parameters")
    table = found.build_table().groupby("block", sort=False)
    for block, rows in table:
        unit, *values, sigma, _ = printed[block.replace(".", " ")]
        assert unit == rows["unit"].iloc[0]
        np.testing.assert_allclose(
            [float(value) for value in values], rows["estimate"], atol=0.06 * rows["sigma"].max()
        )
        assert float(sigma) == pytest.approx(rows["sigma"].max(), rel=0.05)
    assert parse_table(summary, "Tests").keys() >= {"noise of sun", "whiteness of mag", "prior"}
    tests = parse_table(complete, "Errors that the scenario does not model")
    assert tests.keys() >= set(found.build_model_test_table().index)


def test_screen_says_whether_each_required_sigma_is_satisfied(run, flight, tmp_path):
    folder, scenario, _ = flight
    required = {"attitude_deg": 0.001, "mag.bias_nt": 400.0}
    dataclasses.replace(scenario, required_sigma=required).save(tmp_path / "required.toml")
    command = ("calibrate", folder / "telemetry.csv", "--scenario", tmp_path / "required.toml")
    text = run(*command).stdout
    verdict = " ".join(text.partition("\n\n")[0].split())
    assert "1 of 2 required 1-sigmas is violated: attitude" in verdict
    rows = parse_table(text, "Required 1-sigma")
    assert (rows["attitude"][-1], rows["mag bias"][-1]) == ("VIOLATED", "satisfied")
    document = json.loads(run(*command, "--json").stdout)
    assert [row["satisfied"] for row in document["requirements"]] == [False, True]


def test_scenario_with_another_epoch_than_plan_raises(run, flight, tmp_path):
    # For example the scenario of a search with a free start time, where the plan has its own epoch.
    folder, scenario, _ = flight
    later = scenario.epoch + timedelta(hours=14)
    dataclasses.replace(scenario, epoch=later).save(tmp_path / "s.toml")
    command = ("calibrate", folder / "telemetry.csv", "--plan", folder / "plan.json")
    told = run(*command, "--scenario", tmp_path / "s.toml", code=2).stderr
    assert "the epoch is 2018-06-05T14:00:00.000Z" in told
    assert "expected the epoch of the plan, 2018-06-05T00:00:00.000Z" in " ".join(told.split())


@pytest.mark.slow
def test_all_checks_of_refused_telemetry_are_printed(run, flight, tmp_path):
    folder, _, telemetry = flight
    fast = dataclasses.replace(telemetry, gyro_deg_s=3600.0 * telemetry.gyro_deg_s)
    fast.to_csv(tmp_path / "t.csv")
    command = ("calibrate", tmp_path / "t.csv", "--plan", folder / "plan.json")
    done = run(*command, "--all", code=2)
    message = done.stderr.removeprefix("Error: ").partition(" Message of the fit")[0]
    assert message.startswith("gyro at row ")
    assert "gyro at row " in done.stdout
    report = json.loads(run(*command, "--all", "--json", code=2).stdout)
    assert report["error"].startswith(message)
    findings = [finding for each in report["checks"].values() for finding in each]
    assert f"{findings[0]}." == message
    assert run(*command, code=2).stdout == ""


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((), "--scenario FILE.toml|PRESET: expected this option or --plan"),
        (("--scenario", "paper", "--mapping", "none.toml"), "none.toml"),
        (("--scenario", "paper", "--pick", "min-trace"), "--pick: expected with --plan RUN"),
    ],
)
def test_invalid_arguments_raise(run, flight, monkeypatch, arguments, message):
    monkeypatch.chdir(flight[0])
    done = run("calibrate", "telemetry.csv", *arguments, code=2)
    assert done.stdout == ""
    assert done.stderr.startswith("Error: ")
    assert message in done.stderr
    assert done.stderr.count("\n") == 1


def test_invalid_telemetry_leaves_no_files(run, flight, tmp_path):
    folder, _, _ = flight
    text = (folder / "telemetry.csv").read_text()
    (tmp_path / "t.csv").write_text(text.replace("mag_x", "\x1b[2Jmag_x", 1))
    done = run(
        "calibrate", tmp_path / "t.csv", "--scenario", "paper", "--out", tmp_path / "o", code=2
    )
    assert re.fullmatch(
        r"Error: .*t\.csv: missing columns mag_x: the table has the columns .*\n", done.stderr
    )
    assert "\x1b" not in done.stderr
    assert not (tmp_path / "o").exists()
    run("calibrate", tmp_path / "none.csv", "--scenario", "paper", code=2)
    run("calibrate", tmp_path, "--scenario", "paper", code=2)


@pytest.mark.slow
def test_repeated_calibration_is_compared_with_the_first(run, flight):
    folder, _, _ = flight
    command = ("calibrate", folder / "telemetry.csv", "--plan", folder / "plan.json")
    printed = run(*command, "--fit", " mag.scale_factor").stdout
    rows = parse_table(printed, "Comparison of the repeated calibration with the first calibration")
    assert rows["mag scale factor x"]
    refused = run(*command, "--fit", "mag.gain", code=2)
    assert "fit = 'mag.gain': " in refused.stderr
