"""Fronts from folders that mgeo itself wrote, and from folders that somebody has touched."""

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
def written(run, tmp_path_factory):
    folder = tmp_path_factory.mktemp("run") / "one"
    write_run(folder, run)
    return folder


def test_picks(run, written):
    front = read_front(written)
    F = run.outcome.F
    fastest, best, knee = (
        front.select_plan(choice) for choice in ("min-time", "min-trace", "knee")
    )
    assert fastest.t_end == F[:, 0].min()
    assert best.trace == pytest.approx(F[:, 1].min(), rel=1e-9)
    # the knee lies below the line through the ends, as no other point does
    points = front.problem.map_to_indicator_space(F[find_front_rows(F)])
    (x0, y0), (x1, y1) = points[0], points[-1]
    below = (points - points[0]) @ [y1 - y0, x0 - x1]
    bend = F[find_front_rows(F)[np.argmax(below)]]
    assert (knee.t_end, knee.trace) == (bend[0], pytest.approx(bend[1], rel=1e-9))
    chosen = select_representative_solutions(front.problem, F, front.problem.obj_names)
    assert [s.row for s in chosen if s.label == "knee"] == [front.find_row("knee")]
    times = F[:, 0]
    for seconds in (0.0, 1900.0, 1e9):
        nearest = times[np.argmin(np.abs(times - seconds))]
        assert front.select_plan(seconds).t_end == nearest


def test_a_bad_value_in_the_configuration_is_named_with_file_and_key(written, tmp_path):
    folder = shutil.copytree(written, tmp_path / "run")
    path = folder / "run.json"
    data = json.loads(path.read_text(encoding="utf-8"))
    data["configuration"]["options"]["gyro"]["initial_bias_deg_s"] = -1.0
    path.write_text(json.dumps(data), encoding="utf-8")
    message = r"run\.json: .*configuration\.options\.gyro\.initial_bias_deg_s = -1\.0"
    with pytest.raises(ValueError, match=message):
        read_front(folder)


def test_fastest_and_best_are_of_t_end_and_trace_whatever_was_minimized(tmp_path):
    scenario = dataclasses.replace(Scenario.paper(), duration=2400.0, step=4.0)
    problem = AttitudeManeuverProblem(scenario, objectives=("log_det", "angle"))
    write_run(tmp_path / "run", small_run(problem))
    front = read_front(tmp_path / "run")
    paper = AttitudeManeuverProblem(scenario).evaluate(front.X, return_values_of=["F"])
    assert front.select_plan("min-time").t_end == paper[:, 0].min()
    assert front.select_plan("min-trace").trace == pytest.approx(paper[:, 1].min(), rel=1e-9)


def test_a_plan_of_a_run_is_what_the_run_has_stored(tmp_path, monkeypatch):
    """Nothing is evaluated; the same plan from its design evaluates to the same document."""
    scenario = dataclasses.replace(Scenario.paper(), duration=900.0, step=4.0)
    problem = AttitudeManeuverProblem(scenario, n_runs=4)
    run = small_run(problem)
    write_run(tmp_path / "run", run)
    view = problem.view(run.outcome.X)
    write_arrays(tmp_path / "run", run.outcome, view.arrays())
    with monkeypatch.context() as patch:
        patch.setattr("mgeo_attitude.problem.evaluate", None)
        plan = read_front(tmp_path / "run").get_solution(0)
        found = to_json(plan)
    np.testing.assert_array_equal(plan.view.F, run.outcome.F[:1])
    assert found == to_json(ManeuverPlan(problem.scenario, tuple(run.outcome.X[0])))
