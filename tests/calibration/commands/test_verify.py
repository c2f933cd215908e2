"""``mgeo attitude verify``: output and exit codes."""

import dataclasses
import json
import shutil

import pytest
from mgeo_attitude import AttitudeManeuverProblem, Scenario
from mgeo_attitude.plan import ManeuverPlan, write_plan
from mgeo_attitude.scenario.constraints import PathConstraint
from mgeo_calibration import verify
from mgeo_calibration.simulators.plan_comparison import format_gyro_guidance
from mgeo_calibration.verification import format_conclusion

from mgeo.report.build import build_report_html, read_verifications
from mgeo.store.run_folder import read_run

from .screens import parse_table


@pytest.mark.slow
def test_result_file_appears_in_report(run, folder, front, tmp_path):
    found = verify(front.select_plan("min-trace"), n_runs=3, seed=2)
    file = tmp_path / "verification-min-trace.json"
    arguments = (
        "verify",
        folder,
        "--pick",
        "min-trace",
        "--monte-carlo",
        "3",
        "--seed",
        "2",
        "--out",
        file,
    )
    run(*arguments, code=0 if found.is_achieved else 3)
    printed = run(*arguments[:-2], "--json", code=0 if found.is_achieved else 3).stdout
    assert json.loads(printed) == json.loads(file.read_text())
    quiet = run(*arguments[:-2], "--quiet", code=0 if found.is_achieved else 3)
    assert quiet.stdout + quiet.stderr == ""
    run_too = shutil.copytree(folder, tmp_path / "run")
    shutil.copy(file, run_too)
    html = (
        build_report_html(run_too)
        .partition("<section id=verification>")[2]
        .partition("</section>")[0]
    )
    assert f"(verification-min-trace.json, plan {front.find_row('min-trace')})" in html
    assert found.table.shape[0] == 18
    assert all(f">{name}</t" in html for name in found.table.index)
    row = html.partition(">gyro bias y</t")[2].partition("</tr>")[0]
    assert f"{found.table.loc['gyro bias y', 'rms']:.3g}" in row
    assert "exists" in run(*arguments, code=2).stderr


@pytest.fixture(scope="module")
def flown(front):
    return verify(front.select_plan("min-time"), n_runs=2)


def test_result_is_stored_in_run_folder(run, folder, front, flown, tmp_path, monkeypatch):
    table = flown.table.assign(**{"p, predicted": 1.0, "p, filter": 1.0})
    made = dataclasses.replace(flown, table=table, nees_p=1.0)
    monkeypatch.setattr("mgeo_calibration.verification.verify", lambda *_: made)
    own = shutil.copytree(folder, tmp_path / "run")
    row = front.find_row("min-time")
    run("verify", own, "--pick", "min-time", "--seed", "3", "--json")
    kept = own / f"verification-solution{row}-seed3.json"
    shown = {name: why for name, why, _ in read_verifications(own, read_run(own), front.problem)}
    assert shown[kept.name] == ""
    document = json.loads(kept.read_text())
    assert document["design"] == front.X[row].tolist()
    assert {"rms error", "p-value (predicted)"} < set(document["columns"])
    write_plan(front.select_plan("min-time"), tmp_path / "alone.json")
    run("verify", tmp_path / "alone.json")
    assert {path.name for path in tmp_path.iterdir()} == {"run", "alone.json"}


def test_invalid_input_exits_with_code_2(run, folder, tmp_path):
    assert "holds no run" in run("verify", tmp_path, code=2).stderr
    run("verify", folder, "--monte-carlo", "1", code=2)


@pytest.mark.slow
def test_path_constraint_violation_is_reported(run, tmp_path, monkeypatch):
    """The violation appears in the verdict, as a table, and in the result document."""
    scenario = dataclasses.replace(
        Scenario.paper(),
        duration=400.0,
        step=2.0,
        path_constraints=(
            PathConstraint(name="camera", boresight=(1.0, -1.0, 0.0), half_angle_deg=60.0),
        ),
    )
    problem = AttitudeManeuverProblem(scenario)
    turning = [1.0, 0.0, 0.0, 30.0, 0.0, 1.0, 0.0, 30.0, 0.0, 0.0, 1.0, 30.0]
    plan = ManeuverPlan.from_design(problem, turning)
    write_plan(plan, tmp_path / "plan.json")
    found = verify(plan, n_runs=4, seed=2)
    (steered, _, open_loop, _) = found.path_constraints.loc["Sun off camera"]
    assert steered == open_loop == 100.0  # The camera passes the Sun.
    arguments = ("verify", tmp_path / "plan.json", "--monte-carlo", "4", "--seed", "2")
    monkeypatch.setenv("COLUMNS", "80")
    text = run(*arguments, code=3).stdout
    assert format_conclusion(found) in " ".join(text.split())
    assert max(map(len, text.splitlines())) <= 80
    errors = parse_table(text, "Estimation errors after ")
    assert set(found.find_worst_axes()) <= errors.keys()
    worst = found.find_worst_axes()[0]
    assert errors[worst][-1] == ("FAILED" if worst in found.find_failed_states() else "passed")
    violations = text.partition("Violations of path constraints")[2].partition("\n\n")[0]
    shares = [line.split()[-2] for line in violations.splitlines() if "Sun off" in line]
    assert shares == ["100", "100"]
    guided = parse_table(text, "Motion with gyro-based guidance")
    assert guided["Sun off camera"][-2:] == ["min 60", "100"]
    assert float(guided["largest rate per axis"][1]) == pytest.approx(1.0)  # one axis at a time
    assert "attitude y" in run(*arguments, "--all", code=3).stdout
    document = json.loads(run(*arguments, "--json", code=3).stdout)
    (guidance,) = format_gyro_guidance(found.gyro_guidance)
    assert "Sun off camera is violated in 100 % of runs" in document["conclusion"]
    assert guidance in document["conclusion"]
    assert "Sun off camera is violated in 100 %" in guidance
    rows = {row["quantity"]: row for row in document["gyro_guidance"]}
    assert rows["Sun off camera"]["violated_percent"] == 100.0
    (row,) = document["path_constraints"]
    assert row["path_constraint"] == "Sun off camera"
    assert row["steered_runs_percent"] == 100.0
    assert 0.0 < row["open_loop_time_percent"] < 100.0
