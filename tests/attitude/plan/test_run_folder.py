"""Fronts from folders that mgeo itself wrote, and from folders that somebody has touched."""

import dataclasses
import json
import shutil

import numpy as np
import pytest
from mgeo_attitude import AttitudeManeuverProblem, Scenario
from mgeo_attitude.plan import read_front

from mgeo.evaluation.dominance import front_rows
from mgeo.runs.answer import representative_solutions
from mgeo.store.run_folder import write_run

from ..small_run import small_run


@pytest.fixture(scope="module")
def run():
    scenario = dataclasses.replace(Scenario.paper(), duration=2400.0)
    return small_run(AttitudeManeuverProblem(scenario))


@pytest.fixture(scope="module")
def written(run, tmp_path_factory):
    folder = tmp_path_factory.mktemp("run") / "one"
    write_run(folder, run)
    return folder


@pytest.fixture
def folder(written, tmp_path):
    """A copy that a test may touch."""
    return shutil.copytree(written, tmp_path / "run")


def test_it_is_read_as_it_was_written(run, written):
    front = read_front(written)
    np.testing.assert_array_equal(front.X, run.outcome.X)
    np.testing.assert_array_equal(front.F, run.outcome.F)
    assert front.problem.options() == run.configuration.options
    assert len(front.F) > 5  # enough for picks to differ


def test_picks_where_others_than_the_paper_s_were_minimized(tmp_path):
    """Fastest and best are still those of t_end and trace; the file's values are still checked."""
    scenario = dataclasses.replace(Scenario.paper(), duration=2400.0)
    problem = AttitudeManeuverProblem(scenario, objectives=("log_det", "t_end", "angle"))
    run = small_run(problem)
    write_run(tmp_path / "run", run)
    front = read_front(tmp_path / "run")
    assert front.problem.objectives == problem.objectives
    np.testing.assert_array_equal(front.F, run.outcome.F)
    paper = AttitudeManeuverProblem(scenario).evaluate(front.X, return_values_of=["F"])
    fastest, best, knee = (front.plan(choice) for choice in ("fastest", "best", "knee"))
    assert fastest.t_end == paper[:, 0].min() == front.F[:, 1].min()
    assert best.trace == pytest.approx(paper[:, 1].min(), rel=1e-9)
    chosen = representative_solutions(problem, front.F, problem.obj_names)
    assert [s.row for s in chosen if s.label == "knee"] == [front.row("knee")]
    assert knee.design == tuple(front.X[front.row("knee")])
    table = (tmp_path / "run" / "front.csv").read_text()
    row = front.row("fastest")
    value = repr(float(front.F[row, 0]))
    assert value in table
    (tmp_path / "run" / "front.csv").write_text(table.replace(value, repr(float(value) * 1.01)))
    with pytest.raises(ValueError, match="log10 of the determinant"):
        read_front(tmp_path / "run").plan("fastest")


def test_picks(run, written):
    front = read_front(written)
    F = run.outcome.F
    fastest, best, knee = (front.plan(choice) for choice in ("fastest", "best", "knee"))
    assert fastest.t_end == F[:, 0].min()
    assert best.trace == pytest.approx(F[:, 1].min(), rel=1e-9)
    # the knee lies below the line through the ends, as no other point does
    points = front.problem.indicator_space(F[front_rows(F)])
    (x0, y0), (x1, y1) = points[0], points[-1]
    below = (points - points[0]) @ [y1 - y0, x0 - x1]
    bend = F[front_rows(F)[np.argmax(below)]]
    assert (knee.t_end, knee.trace) == (bend[0], pytest.approx(bend[1], rel=1e-9))
    chosen = representative_solutions(front.problem, F, front.problem.obj_names)
    assert [s.row for s in chosen if s.label == "knee"] == [front.row("knee")]
    times = F[:, 0]
    for seconds in (0.0, 1900.0, 1e9):
        nearest = times[np.argmin(np.abs(times - seconds))]
        assert front.plan(seconds).t_end == nearest


@pytest.mark.parametrize("column", [-1, -2])
def test_objectives_that_the_filter_does_not_give_are_refused(folder, column):
    path = folder / "front.csv"
    lines = path.read_text().splitlines()
    row = read_front(folder).row("best")
    cells = lines[row + 1].split(",")
    cells[column] = repr(float(cells[column]) * (1.0 - 1e-5))
    lines[row + 1] = ",".join(cells)
    path.write_text("\n".join(lines) + "\n")
    with pytest.raises(ValueError, match=rf"front\.csv: row {row + 1}, .*the filter gives"):
        read_front(folder).plan("best")


def edit(folder, change):
    path = folder / "run.json"
    data = json.loads(path.read_text(encoding="utf-8"))
    change(data)
    path.write_text(json.dumps(data), encoding="utf-8")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda d: d.update(format=1), "format = 1: this version of mgeo reads format 2"),
        (lambda d: d.update(format=True), "format = True"),
        (lambda d: d.pop("configuration"), "configuration is missing"),
        (lambda d: d.update(configuration=[]), r"configuration = \[\]"),
        (lambda d: d["configuration"].update(problem="zdt1"), r"configuration\.problem = 'zdt1'"),
        (lambda d: d["configuration"].update(options=3), r"options = 3: expected a table"),
        (
            lambda d: d["configuration"]["options"]["gyro"].update(initial_bias_deg_s=-1.0),
            r"configuration\.options\.gyro\.initial_bias_deg_s = -1\.0",
        ),
        (
            lambda d: d["configuration"]["options"]["maneuvers"].update(count=10**8),
            r"configuration\.options\.maneuvers\.count = 100000000: expected an integer in \[1, 1",
        ),
    ],
)
def test_what_was_changed_in_the_configuration_is_named(folder, change, message):
    edit(folder, change)
    with pytest.raises(ValueError, match=message) as error:
        read_front(folder)
    assert "run.json" in str(error.value)
