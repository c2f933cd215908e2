"""``mgeo attitude show``: printed tables, JSON and figures against the plan."""

import dataclasses
import json
import re

import numpy as np
import pytest
from mgeo_attitude import AttitudeManeuverProblem, Scenario
from mgeo_attitude.plan import ManeuverPlan, to_json
from mgeo_attitude.plan.tables import TABLES
from mgeo_attitude.scenario import Wheels

from mgeo.store.run_folder import write_run

from ..small_run import small_run


def parse_table(text, title):
    """Return the rows of a printed table as lists of cells, by the label of the row."""
    lines = text.partition(f"\n{title}")[2].split("\n\n")[0].splitlines()[1:]
    cells = [re.split(r"  +", line.strip()) for line in lines]
    return {row[0]: row[1:] for row in cells}


def test_all_tables_of_the_knee_are_printed(run, folder, front, monkeypatch):
    monkeypatch.setenv("COLUMNS", "400")  # Each row is one line.
    plan = front.select_plan("knee")
    text = run("show", folder).stdout
    assert text.startswith(
        f"solution {front.find_row('knee')} of {len(front.X)}, knee: {plan.summary}\n"
    )
    for each in TABLES.values():
        assert (f"\n{each.title}\n" in text) == (len(each.table(plan)) > 0)
    after = plan.build_accuracy_table().loc["mag bias x", "after"]
    assert parse_table(text, "Predicted 1-sigma")["mag bias x"][:3] == [
        "nT",
        "2000",
        f"{after:.4g}",
    ]
    others = parse_table(text, "Comparison with plans that need no optimizer")
    assert others["trace [-]"][0] == f"{plan.trace:.4g}"
    assert "\x1b" not in text


@pytest.mark.parametrize("option", ["--time", "--solution"])
def test_plan_is_selected_by_time_or_number(run, folder, front, option):
    number = len(front.X) - 2 if option == "--solution" else front.find_row(1900.0)
    given = number if option == "--solution" else 1900
    document = json.loads(run("show", folder, option, given, "--json").stdout)
    assert document["solution"] == number
    assert document["design"] == front.X[number].tolist()


def test_uncalibrated_errors_are_noted(run, front, tmp_path):
    idle_plan = ManeuverPlan.from_design(front.problem, np.zeros(12))
    errors = idle_plan.list_uncalibrated_errors()
    assert any(text.startswith("sun misalignment (") for text in errors)
    path = tmp_path / "still.json"
    path.write_text(to_json(idle_plan), encoding="utf-8")
    note = f"Note: this plan hardly reduces the error of {', '.join(errors)}\n"
    assert note in run("show", path).stdout
    assert run("export", path, tmp_path / "still.csv").stderr.startswith(note)
    assert run("export", path, tmp_path / "quiet.csv", "--quiet").stderr == ""


@pytest.mark.slow
def test_nearest_plan_of_infeasible_run_is_shown(run, tmp_path):
    wheels = Wheels(inertia=(0.1, 0.1, 0.1), max_momentum=1e-9)
    scenario = dataclasses.replace(Scenario.paper(), duration=600.0, wheels=wheels)
    infeasible_run = small_run(AttitudeManeuverProblem(scenario))
    write_run(tmp_path / "run", infeasible_run)
    nearest = infeasible_run.outcome.nearest
    text = run("show", tmp_path / "run").stdout
    assert text.startswith("no plan of this run satisfies all constraints; nearest solution 0: ")
    found = parse_table(text, "Constraints")["wheel momentum"]
    excess = nearest.violation[0, 0]
    assert float(found[1]) == pytest.approx(1e-9 * (1.0 + excess), rel=1e-3)
    assert found[-1] == "violated"
    document = json.loads(run("show", tmp_path / "run", "--solution", 3, "--json").stdout)
    assert document["design"] == nearest.X[3].tolist()
    rejected = run("export", tmp_path / "run", tmp_path / "plan.json", code=2)
    assert "the plan violates 1 of its scenario's constraints" in rejected.stderr


@pytest.mark.slow
def test_figures_are_written(run, folder, tmp_path):
    path = tmp_path / "plan.html"
    assert run("show", folder, "--html", path).stdout.endswith(f"\nwrote {path}\n")
    html = path.read_text(encoding="utf-8")
    assert html.count('class="plotly-graph-div"') == 4
    run("show", folder, "--html", path, code=2)
    assert not run("show", folder, "--quiet", "--html", path, "--overwrite").stdout
    assert path.read_text(encoding="utf-8") == html


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--pick", "slowest"), "--pick slowest: expected one of knee, min-time, min-trace"),
        (("--solution", "3", "--time", "3"), "--time and --solution: expected one of them"),
        (("--solution", "1000"), "solution 1000: expected 0 to"),
        (("--html", "nowhere/plan.html"), "there is no folder nowhere"),
    ],
)
def test_invalid_arguments_are_rejected(run, folder, arguments, message):
    done = run("show", folder, *arguments, code=2)
    assert done.stdout == ""
    assert done.stderr.startswith("Error: ")
    assert message in done.stderr
    assert done.stderr.count("\n") == 1


def test_invalid_sources_are_rejected(run, folder, tmp_path):
    assert "expected a run folder or a plan file" in run("show", tmp_path / "x", code=2).stderr
    plan = tmp_path / "plan.json"
    plan.write_text("{}")
    assert "plan.json: format = None" in run("show", plan, code=2).stderr
    other = tmp_path / "sat.toml"
    other.write_text('preset = "paper"\n')
    assert "expected the run folder of mgeo solve" in run("show", other, code=2).stderr
    assert "--pick applies to run folders" in run("show", plan, "--pick", "knee", code=2).stderr
