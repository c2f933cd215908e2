"""Fronts from run folders that mgeo wrote, and from a folder with an invalid configuration."""

import dataclasses
import json
import shutil

import numpy as np
import pytest
from mgeo_attitude import AttitudeManeuverProblem, Scenario
from mgeo_attitude.plan import ManeuverPlan, read_front, to_json

from mgeo.evaluation.dominance import find_front_rows
from mgeo.runs.summary import select_representative_solutions
from mgeo.store.run_folder import write_arrays, write_run

from ..small_run import small_run


@pytest.fixture(scope="module")
def run():
    scenario = dataclasses.replace(Scenario.paper(), duration=2400.0, step=4.0)
    return small_run(AttitudeManeuverProblem(scenario))


@pytest.fixture(scope="module")
def run_folder(run, tmp_path_factory):
    folder = tmp_path_factory.mktemp("run") / "one"
    write_run(folder, run)
    return folder


def test_plans_are_selected_by_rule_and_by_time(run, run_folder):
    front = read_front(run_folder)
    F = run.outcome.F
    min_time, min_trace, knee = (
        front.select_plan(choice) for choice in ("min-time", "min-trace", "knee")
    )
    assert min_time.t_end == F[:, 0].min()
    assert min_trace.trace == pytest.approx(F[:, 1].min(), rel=1e-9)
    # No other point lies as far below the line through the ends as the knee.
    points = front.problem.map_to_indicator_space(F[find_front_rows(F)])
    (x0, y0), (x1, y1) = points[0], points[-1]
    distances = (points - points[0]) @ [y1 - y0, x0 - x1]
    expected_knee = F[find_front_rows(F)[np.argmax(distances)]]
    assert (knee.t_end, knee.trace) == (
        expected_knee[0],
        pytest.approx(expected_knee[1], rel=1e-9),
    )
    representatives = select_representative_solutions(front.problem, F)
    assert [s.row for s in representatives if s.label == "knee"] == [front.find_row("knee")]
    times = F[:, 0]
    for seconds in (0.0, 1900.0, 1e9):
        nearest = times[np.argmin(np.abs(times - seconds))]
        assert front.select_plan(seconds).t_end == nearest


def test_invalid_configuration_is_reported_with_file_and_key(run_folder, tmp_path):
    folder = shutil.copytree(run_folder, tmp_path / "run")
    path = folder / "run.json"
    data = json.loads(path.read_text(encoding="utf-8"))
    data["configuration"]["options"]["gyro"]["initial_bias_deg_s"] = -1.0
    path.write_text(json.dumps(data), encoding="utf-8")
    message = r"run\.json: .*configuration\.options\.gyro\.initial_bias_deg_s = -1\.0"
    with pytest.raises(ValueError, match=message):
        read_front(folder)


def test_min_time_and_min_trace_do_not_depend_on_objectives(tmp_path):
    scenario = dataclasses.replace(Scenario.paper(), duration=2400.0, step=4.0)
    problem = AttitudeManeuverProblem(scenario, objectives=("log_det", "angle"))
    write_run(tmp_path / "run", small_run(problem))
    front = read_front(tmp_path / "run")
    F = AttitudeManeuverProblem(scenario).evaluate(front.X, return_values_of=["F"])
    assert front.select_plan("min-time").t_end == F[:, 0].min()
    assert front.select_plan("min-trace").trace == pytest.approx(F[:, 1].min(), rel=1e-9)


def test_plan_of_run_uses_stored_results(tmp_path, monkeypatch):
    """Nothing is evaluated, and the document equals that of the plan of the same design."""
    scenario = dataclasses.replace(Scenario.paper(), duration=900.0, step=4.0)
    problem = AttitudeManeuverProblem(scenario, n_runs=4)
    run = small_run(problem)
    write_run(tmp_path / "run", run)
    view = problem.view(run.outcome.X)
    write_arrays(tmp_path / "run", run.outcome, view.arrays())
    with monkeypatch.context() as patch:
        patch.setattr("mgeo_attitude.problem.evaluate", None)
        plan = read_front(tmp_path / "run").get_solution(0)
        document = to_json(plan)
    np.testing.assert_array_equal(plan.view.F, run.outcome.F[:1])
    assert document == to_json(ManeuverPlan(problem.scenario, tuple(run.outcome.X[0])))
