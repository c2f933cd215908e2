"""Overview of a plan, comparison of plans, warnings, and the screen of ``mgeo solve``."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from mgeo_attitude import AttitudeManeuverProblem, Scenario, run_filter
from mgeo_attitude.lower_bound.samples import NoLowerBoundError
from mgeo_attitude.plan import ManeuverPlan
from mgeo_attitude.view.overview import build_accuracy_table, build_maneuver_table
from typer.testing import CliRunner

from mgeo.cli.app import app
from mgeo.runs.summary import summarize_front

DESIGN = (0.9, 0.5, -1.0, 150.0, -1.0, 0.8, 0.6, 200.0, 0.7, -0.6, 1.0, 180.0)
SHORT = {"preset": "cubesat_6u", "duration": 1200.0, "maneuvers": {"count": 3}}
WHEELS = {"inertia": [0.13, 0.1, 0.05], "max_torque": 1e-3, "max_momentum": 5e-3}
CAMERA = {"name": "camera", "boresight": [0.0, 0.0, 1.0], "half_angle_deg": 20.0}


def build_plan(**options):
    return ManeuverPlan(Scenario.from_dict(SHORT | options), DESIGN)


@pytest.fixture(scope="module")
def plan():
    return build_plan()


def test_accuracy_is_that_of_the_plan_and_of_its_lower_bound(plan):
    table, states = build_accuracy_table(plan.view), plan.build_accuracy_table()
    predicted = states["after"].to_numpy().reshape(-1, 3).max(axis=1)
    np.testing.assert_allclose(table["predicted"], predicted)
    bound = plan.problem.lower_bound.compute_sigma("attitude")[plan.to_steps(plan.t_end)]
    assert table["lower bound"].iloc[0] == pytest.approx(np.degrees(bound))
    np.testing.assert_allclose(table["ratio"], table["predicted"] / table["lower bound"])
    assert (table["ratio"] >= 1.0 - 1e-9).all()
    before = states["before"].to_numpy().reshape(-1, 3).max(axis=1)
    np.testing.assert_allclose(table["before"], before)
    (attitude,) = plan.view.monte_carlo_sigma_deg
    assert table["90 % of runs"].iloc[0] == pytest.approx(attitude)
    assert (table["90 % of runs"] > 0.5 * table["predicted"]).all()


def test_column_titles_have_the_words_of_the_field(plan):
    titles = [plan.view.format_title(name) for name in plan.view.describe()]
    assert not any(re.search(r"t_end|\[-\]", title) for title in titles)
    assert len(set(titles)) == len(titles)
    paper = AttitudeManeuverProblem(Scenario.paper()).view(np.zeros((0, 12)))
    assert paper.format_title("t_end [s], nominal") == "convergence time [s], nominal"
    assert paper.format_title("trace [-], nominal") == "weighted trace of covariance, nominal"
    assert paper.format_title("trace / lower bound [-]") == "trace / lower bound"


def test_lower_bound_is_left_out_if_none_can_be_proved(monkeypatch):
    def fail(self):
        raise NoLowerBoundError("none")

    monkeypatch.setattr(AttitudeManeuverProblem, "lower_bound", property(fail))
    overview = build_plan().view.overview()
    assert "lower bound" not in overview["accuracy"].table
    assert "trace / bound [-]" not in build_plan().view.front_table()


def test_maneuvers_are_those_of_the_timeline(plan):
    table, timeline = build_maneuver_table(plan.view), plan.build_timeline()
    assert table.index.tolist() == ["1", "2", "3"]
    for name, other in (
        ("start [s]",) * 2,
        ("duration [s]",) * 2,
        ("angle [deg]", "rotation [deg]"),
    ):
        assert table[name].tolist() == timeline[other].tolist()
    assert table["ωx [deg/s]"].tolist() == list(DESIGN[::4])
    uncertainty = plan.compute_uncertainty_by_phase()
    worst = uncertainty.filter(regex="attitude").max(axis=1).to_numpy()
    assert table["most reduced"].iloc[0] == "attitude"
    assert table["factor"].iloc[0] == pytest.approx(worst[0] / worst[1])


def test_maneuver_includes_its_ramp_and_slew_back_is_one_row():
    plan = build_plan(
        wheels=WHEELS, maneuvers={"count": 3, "max_acceleration_deg_s2": 0.05, "slew_back": True}
    )
    table, timeline = build_maneuver_table(plan.view), plan.build_timeline()
    assert table.index.tolist() == ["1", "2", "3", "slew back"]
    assert len(timeline) > len(table)
    assert table["angle [deg]"].sum() == pytest.approx(timeline["rotation [deg]"].sum())
    assert table["duration [s]"].sum() == pytest.approx(plan.duration)
    assert table["ωx [deg/s]"].tolist()[:3] == list(DESIGN[::4])


def test_front_table_has_robust_values_first_and_further_objectives_last():
    options = {"objectives": ["t_end", "trace", "angle"], "monte_carlo": {"n_runs": 4}}
    problem = AttitudeManeuverProblem(Scenario.from_dict(SHORT | options))
    view = problem.view([DESIGN])
    table = view.front_table()
    np.testing.assert_array_equal(table.iloc[:, [0, 1, -1]], view.F)
    assert table["predicted attitude 1-sigma [deg]"].iloc[0] == pytest.approx(
        np.degrees(view.sigma[0, :3].max())
    )


def find_warnings(view, text):
    return [line for line in view.warnings() if text in line]


def test_warning_if_no_actuators_limit_the_rates(plan):
    assert len(find_warnings(plan.view, "[wheels]")) == 1
    assert find_warnings(build_plan(wheels=WHEELS).view, "[wheels]") == []


def test_warning_if_monte_carlo_runs_exceed_the_prediction(plan):
    def count(F):
        view = plan.problem.view(np.tile(DESIGN, (4, 1)))
        view.F = np.tile(F, (4, 1))
        lines = find_warnings(view, "--robust")
        return [int(re.search(r"(\d+) of 4 plans", line)[1]) for line in lines]

    values = plan.view.monte_carlo_objectives[0]
    assert count(values) == []
    assert count(values * [1.0, 0.5]) == [4]


def test_warning_if_initial_errors_are_beyond_validity():
    view = build_plan(initial={"attitude_deg": 40.0}).view
    assert len(find_warnings(view, "initial.attitude_deg = 40")) == 1


def test_warning_if_a_constraint_is_violated_after_convergence():
    options = {"path_constraints": [CAMERA], "monte_carlo": {"n_runs": 4}}
    options["convergence"] = {"rule": "trace"}
    view = build_plan(**options).view
    margins = view.constraints()[0]["margin"].filter(regex="camera .*")
    violated = [name for name, margin in margins.items() if "hold" in name and margin < 0.0]
    assert bool(find_warnings(view, "in the constant-rate hold")) == bool(violated)


def test_each_row_of_a_path_constraint_names_its_phase():
    maneuvers = {"count": 3, "max_acceleration_deg_s2": 0.05, "slew_back": True}
    options = {"path_constraints": [CAMERA], "monte_carlo": {"n_runs": 4}}
    view = build_plan(**options, maneuvers=maneuvers).view
    section = view.overview()["constraints"]
    labels = [label for label in section.table.index if "camera" in label]
    assert {label.partition(" in the ")[2] for label in labels} == {"maneuvers", "slew back"}
    assert "4 Monte Carlo runs" in section.note


@pytest.mark.parametrize("rule", ["required", "end"])
def test_required_accuracy_is_compared_with_the_accuracy_after_the_slew_back(rule):
    """With the rule "required", the accuracy must last until the end of the scenario."""
    slew_back = {"count": 3, "max_acceleration_deg_s2": 0.05, "slew_back": True}
    options = {"maneuvers": slew_back, "required_sigma": {"attitude_deg": 0.06}}
    plan = build_plan(**options, convergence={"rule": rule})
    model, trajectory = plan.problem.model, plan.trajectory
    run = run_filter(model.full_duration_model, trajectory.commanded_design)
    first = round(trajectory.end / model.step)
    sigma_deg = np.degrees(run.sigma[first:, :3].max(axis=1))
    expected = sigma_deg.max() if rule == "required" else sigma_deg[0]
    (table,) = plan.view.constraints()
    row = table.loc["1-sigma of attitude after the slew back"]
    assert row["value"] == pytest.approx(expected, rel=1e-9)
    assert table["margin"].iloc[0] > 0.0
    assert (row["margin"] < 0.0) == (rule == "required")
    warnings = find_warnings(plan.view, "1-sigma of attitude after the slew back")
    assert len(warnings) == (rule == "required")
    (violated,) = summarize_front(plan.view).front["violated"]
    assert violated == [row.name] * (rule == "required")


@pytest.mark.parametrize("rule", ["trace", "required", "settling", "end"])
def test_end_of_a_plan_is_described_by_its_rule(rule):
    options = {"convergence": {"rule": rule}, "required_sigma": {"attitude_deg": 0.06}}
    view = build_plan(**options, duration=3000.0).view
    converges = rule in ("trace", "settling")
    assert view.overview()["end"].lines[0].startswith("Converges" if converges else "Ends")
    assert ("converges after [s]" in view.front_table()) == converges
    assert ("ends after [s]" in view.front_table()) != converges


@pytest.mark.cases(1)
@pytest.mark.parametrize(
    "scenario", ["cubesat_6u", "paper", "cubesat_6u_full", "microsatellite", "cubesat_1u"]
)
def test_screen_is_at_most_80_by_40(scenario, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "80")
    arguments = ["solve", "attitude", "--scenario", scenario, "--evaluations", "120", "--out", "a"]
    done = CliRunner().invoke(app, arguments, prog_name="mgeo")
    assert done.exit_code == 0, done.output
    lines = done.stdout.splitlines()
    assert max(map(len, lines)) <= 80
    assert len(lines) <= 40
    assert [line for line in lines if line.endswith("mgeo attitude show a")]


def test_screen_has_the_numbers_of_the_document(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("short.toml").write_text(
        'preset = "cubesat_6u"\nduration = 1200.0\nmaneuvers.count = 2\n'
        "wheels = {inertia = [0.13, 0.1, 0.05], max_torque = 1e-3, max_momentum = 3e-3}\n"
        "required_sigma.attitude_deg = 5.0\n"
    )
    arguments = ["solve", "attitude", "--scenario", "short.toml", "--evaluations", "80"]
    text, json_text = (
        CliRunner().invoke(app, [*arguments, *more], prog_name="mgeo").stdout
        for more in (["--out", "a"], ["--out", "b", "--json"])
    )
    document = json.loads(json_text)
    recommended, lines = document["recommended"], text.splitlines()
    attitude = recommended["accuracy"][0]
    assert attitude["quantity"] == "attitude"
    (row,) = [line.split() for line in lines if line.startswith("attitude  ")]
    keys = ("before", "predicted", "in_90_percent_of_runs", "lower_bound", "ratio")
    np.testing.assert_allclose([float(v) for v in row[2:]], [attitude[k] for k in keys], rtol=0.006)
    assert {each["constraint"] for each in recommended["constraints"]} == {
        "wheel momentum",
        "1-sigma of attitude",
    }
    for each in recommended["constraints"]:
        (row,) = [line for line in lines if line.startswith(each["constraint"])]
        assert float(row.split()[-1]) == pytest.approx(each["margin"], rel=0.006)
    starts = [each["start_s"] for each in recommended["maneuvers"]]
    rows = [re.match(r" *(\d+|hold) +(\d+) +\d+ +-?\d\.\d\d ", line) for line in lines]
    assert [float(row[2]) for row in rows if row] == pytest.approx(starts, abs=0.5)
    times = [each["ends_after_s"] for each in document["front"]]
    assert times == sorted(times)
    assert document["front"][0]["label"].startswith("min-time")
