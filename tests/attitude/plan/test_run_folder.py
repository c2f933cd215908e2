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


@pytest.mark.parametrize(
    ("objectives", "message"),
    [("trace", "options.objectives = 'trace'"), (["tracce"], "did you mean 'trace'")],
)
def test_bad_objectives_are_named(folder, objectives, message):
    data = json.loads((folder / "run.json").read_text())
    data["configuration"]["options"]["objectives"] = objectives
    (folder / "run.json").write_text(json.dumps(data))
    with pytest.raises(ValueError, match=message):
        read_front(folder)


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


def test_a_solution_by_its_number(run, written):
    front = read_front(written)
    for number in (0, 3, len(front.X) - 1):
        assert front.solution(number).design == tuple(run.outcome.X[number])
    for number in (-1, len(front.X)):
        with pytest.raises(
            ValueError, match=rf"solution {number}: expected 0 to {len(front.X) - 1}"
        ):
            front.solution(number)


@pytest.mark.parametrize("choice", ["slowest", "", float("nan"), float("inf")])
def test_other_choices_are_named(written, choice):
    with pytest.raises(ValueError, match="choice = "):
        read_front(written).plan(choice)


def test_dominated_rows_are_never_picked(folder):
    """A front that somebody has put together by hand may hold what no front would."""
    path = folder / "front.csv"
    lines = path.read_text().splitlines()
    cells = lines[1].split(",")
    worse = ",".join([*cells[:-2], cells[-2], "1e3"])
    path.write_text("\n".join([lines[0], worse, *lines[1:]]) + "\n")
    resize(folder, len(lines))
    front = read_front(folder)
    assert all(front.row(choice) != 0 for choice in ("fastest", "knee", "best"))


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


def resize(folder, n):
    edit(folder, lambda d: d.update(solutions=n))
    np.savez(folder / "front.npz", G=np.empty((n, 0)), H=np.empty((n, 0)))


def edit(folder, change):
    path = folder / "run.json"
    data = json.loads(path.read_text(encoding="utf-8"))
    change(data)
    path.write_text(json.dumps(data), encoding="utf-8")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda d: d.update(format=1), "format = 1: this version of mgeo reads format 3"),
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


def test_a_front_of_another_scenario_is_refused(folder):
    edit(folder, lambda d: d["configuration"]["options"].update(eclipse=True, duration=2300.0))
    with pytest.raises(ValueError, match="the filter gives"):
        read_front(folder).plan("best")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda t: t[: len(t) // 2], "row .* values|end of line|finite"),
        (lambda t: t[:-1], "end of line"),
        (lambda t: t.split("\n")[0] + "\n", r": 0 rows .*: expected [1-9]\d* rows"),
        (lambda t: "", "expected a header"),
        (lambda t: t.replace("omega_x_1", "omega_w_1"), "columns"),
        (lambda t: t.split("\n")[0] + "\n" + ",".join(["nan"] * 14) + "\n", "row 1, omega_x_1"),
        (lambda t: t.split("\n")[0] + "\n" + ",".join(["open()"] * 14) + "\n", r"'open\(\)'"),
    ],
)
def test_what_was_changed_in_the_table_is_named(folder, change, message):
    path = folder / "front.csv"
    path.write_text(change(path.read_text()))
    with pytest.raises(ValueError, match=message) as error:
        read_front(folder)
    assert "front.csv" in str(error.value)


def test_rates_beyond_the_limits_are_no_plan(folder):
    path = folder / "front.csv"
    header = path.read_text().split("\n")[0]
    path.write_text(f"{header}\n{','.join(['5', *['0'] * 11, '600', '1e-4'])}\n")
    resize(folder, 1)
    with pytest.raises(ValueError, match=r"front\.csv: design\[0\] = 5\.0: expected -1 to 1"):
        read_front(folder).plan("best")


def test_missing_files(folder, tmp_path):
    with pytest.raises(FileNotFoundError, match="holds no run"):
        read_front(tmp_path)
    (folder / "front.csv").unlink()
    with pytest.raises(FileNotFoundError, match=r"front\.csv"):
        read_front(folder)


def test_a_limit_that_was_tightened_since_is_a_limit(folder):
    edit(folder, lambda d: d["configuration"]["options"]["maneuvers"].update(max_rate_deg_s=0.01))
    with pytest.raises(ValueError, match=r"expected -0\.01 to 0\.01"):
        read_front(folder).plan("best")
