"""``mgeo attitude show``: printed sections, JSON and the page against the plan."""

import dataclasses
import json
import re

import numpy as np
import pytest
from mgeo_attitude import AttitudeManeuverProblem, Scenario
from mgeo_attitude.plan import ManeuverPlan, to_json
from mgeo_attitude.plan.tables import build_sections
from mgeo_attitude.plan_sections import FIRST_PAGE, SECTION_KEYS
from mgeo_attitude.scenario import Wheels

from mgeo._text import format_duration
from mgeo.store.run_folder import write_run

from ..small_run import small_run


def parse_table(text, title):
    """Return the rows of a printed table as lists of cells, by the label of the row."""
    lines = text.partition(f"{title}\n")[2].split("\n\n")[0].splitlines()
    cells = [re.split(r"  +", line.strip()) for line in lines]
    return {row[0]: row[1:] for row in cells}


def check_screen(text, max_lines=None):
    lines = text.splitlines()
    assert max(map(len, lines)) <= 80
    assert max_lines is None or len(lines) <= max_lines
    assert "\x1b" not in text


def write_plan_file(plan, tmp_path):
    path = tmp_path / "plan.json"
    path.write_text(to_json(plan), encoding="utf-8")
    return path


def test_first_page_shows_the_knee(run, folder, front, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    plan = front.select_plan("knee")
    text = run("show", folder).stdout
    check_screen(text, max_lines=62)
    assert f"{front.find_row('knee')} of {len(front.X)}" in text.splitlines()[0]
    assert format_duration(plan.t_end) in text
    attitude = plan.accuracy.loc["attitude"]
    unit, *numbers = parse_table(text, "Predicted accuracy")["attitude"]
    names = ["before", "predicted", "90 % of runs", "lower bound", "ratio"]
    assert unit == "deg"
    assert [float(cell) for cell in numbers] == pytest.approx(attitude[names].to_list(), rel=5e-3)
    maneuver = parse_table(text, "Timeline")["1"]
    assert [float(cell) for cell in maneuver[2:5]] == pytest.approx(plan.design[:3], abs=5e-3)
    assert [f"\n{s.title}\n" in text for s in build_sections(plan)[1:]] == [
        s.key in FIRST_PAGE for s in build_sections(plan)[1:]
    ]


def test_all_and_selected_sections(run, folder, front, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    sections = build_sections(front.select_plan("knee"))
    text = run("show", folder, "--all").stdout
    check_screen(text)
    assert all(f"\n{section.title}\n" in text for section in sections[1:])
    text = run("show", folder, "--section", "budget", "--section", "axes").stdout
    titles = [section.title for section in sections if section.title in text.splitlines()]
    assert titles == ["Accuracy about each body axis", "Error budget"]
    error = run("show", folder, "--section", "budgets", code=2).stderr
    assert "did you mean 'budget'" in error


@pytest.mark.slow
@pytest.mark.parametrize(
    ("preset", "is_robust"),
    [
        ("paper", True),
        ("cubesat_6u", False),
        ("cubesat_6u_full", False),
        ("microsatellite", True),
        ("cubesat_1u", False),
    ],
)
def test_screens_of_presets_fit_the_terminal(run, preset, is_robust, tmp_path, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    scenario = {"preset": preset} | ({"monte_carlo": {"n_runs": 16}} if is_robust else {})
    problem = AttitudeManeuverProblem(Scenario.from_dict(scenario))
    design = np.random.default_rng(1).uniform(problem.xl, problem.xu)
    design[3::4] = np.minimum(design[3::4], 100.0)
    path = write_plan_file(ManeuverPlan.from_design(problem, design), tmp_path)
    check_screen(run("show", path).stdout, max_lines=85)
    check_screen(run("show", path, "--all").stdout)


@pytest.mark.parametrize("option", ["--time", "--solution"])
def test_plan_is_selected_by_time_or_number(run, folder, front, option):
    number = len(front.X) - 2 if option == "--solution" else front.find_row(1900.0)
    given = number if option == "--solution" else 1900
    document = json.loads(run("show", folder, option, given, "--json").stdout)
    assert document["summary"]["solution"] == number
    assert document["summary"]["design"] == front.X[number].tolist()


def test_json_has_all_sections_with_units_in_keys(run, folder, front):
    plan = front.select_plan("min-trace")
    document = json.loads(run("show", folder, "--pick", "min-trace", "--json").stdout)
    assert set(document) <= set(SECTION_KEYS)
    assert document["summary"]["t_end_s"] == plan.t_end
    assert document["summary"]["attitude_1sigma_deg"] == plan.attitude_sigma_deg
    assert document["timeline"][0]["rate_x_deg_s"] == plan.design[0]
    assert document["budget"][-1]["attitude_deg"] == pytest.approx(plan.attitude_sigma_deg)
    assert len(document["directions"]) == 5
    document = json.loads(run("show", folder, "--section", "reduction", "--json").stdout)
    assert list(document) == ["reduction"]


def test_uncalibrated_errors_are_warned_of(run, front, tmp_path):
    idle_plan = ManeuverPlan.from_design(front.problem, np.zeros(12))
    errors = idle_plan.list_uncalibrated_errors()
    assert any(text.startswith("sun misalignment (") for text in errors)
    path = write_plan_file(idle_plan, tmp_path)
    for text in (run("show", path).stdout, run("export", path, tmp_path / "still.csv").stdout):
        assert all(error in " ".join(text.split()) for error in errors)
    assert run("export", path, tmp_path / "quiet.csv", "--quiet").stdout == ""


@pytest.mark.slow
def test_nearest_plan_of_infeasible_run_is_shown(run, tmp_path):
    wheels = Wheels(inertia=(0.1, 0.1, 0.1), max_momentum=1e-9)
    scenario = dataclasses.replace(Scenario.paper(), duration=600.0, wheels=wheels)
    infeasible_run = small_run(AttitudeManeuverProblem(scenario))
    write_run(tmp_path / "run", infeasible_run)
    nearest = infeasible_run.outcome.nearest
    text = run("show", tmp_path / "run").stdout
    assert "nearest plan 0" in text.splitlines()[0]
    found = parse_table(text, "Constraints")["wheel momentum"]
    excess = nearest.violation[0, 0]
    assert float(found[1]) == pytest.approx(1e-9 * (1.0 + excess), rel=6e-3)
    assert found[-1] == "VIOLATED"
    document = json.loads(run("show", tmp_path / "run", "--solution", 3, "--json").stdout)
    assert document["summary"]["design"] == nearest.X[3].tolist()
    assert not document["summary"]["constraints_satisfied"]
    rejected = run("export", tmp_path / "run", tmp_path / "plan.json", code=2)
    assert "the plan violates 1 of its scenario's constraints" in rejected.stderr


def test_page_is_written(run, folder, front, tmp_path):
    path = tmp_path / "plan.html"
    assert str(path) in run("show", folder, "--html", path).stdout
    html = path.read_text(encoding="utf-8")
    for section in build_sections(front.select_plan("knee")):
        assert f">{section.title}</h" in html
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
