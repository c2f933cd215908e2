"""Command ``mgeo solve``."""

import json
import re
from pathlib import Path
from pkgutil import resolve_name

import numpy as np
import pandas as pd
import pytest
from pymoo.problems.multi import ZDT1

from mgeo import View
from mgeo.runs.prepare import PreparedRun
from mgeo.store.run_folder import read_run

REAL = ["--algorithm", "mgeo-real"]
SHORT = ["--evaluations", "400", *REAL, "--walkers", "4", "--set", "sigma=0.05"]


def test_run_folder_reproduces_the_run(mgeo):
    done = mgeo("solve", "cantilever", *SHORT, "--seed", 5)
    assert done.exit_code == 0, done.output
    folder = Path("runs/cantilever-mgeo-real-seed5")
    assert {path.name for path in folder.iterdir()} == {
        *("front.csv", "front.npz", "run.json", "front.html", "run.checkpoint")
    }
    run = read_run(folder)
    assert (run.outcome.stop_reason, run.outcome.n_evaluations) == ("budget", 400)
    again = PreparedRun.from_configuration(run.configuration).solve()
    assert np.array_equal(again.X, run.outcome.X)
    assert np.array_equal(again.F, run.outcome.F)
    assert "drawn by the plugin" in (folder / "front.html").read_text()


def test_robust_run_uses_the_robust_problem(mgeo):
    done = mgeo("solve", "cantilever", "--robust", "--evaluations", 160)
    assert done.exit_code == 0, done.output
    run = read_run("runs/cantilever-robust-mgeo-staged-seed1").configuration
    assert run.options == {"load": pytest.approx(1100.0)}
    assert run.algorithm == "mgeo-staged"
    mgeo("solve", "cantilever", "--robust", "--algorithm", "nsga2", *SHORT[:2], "--out", "b")
    assert read_run("b").configuration.algorithm == "nsga2"
    result = mgeo("solve", "bnh", "--robust")
    assert result.exit_code == 2
    assert result.stderr == "Error: BNH has no to_robust(): solve it without --robust\n"


def test_problem_known_to_be_infeasible_is_not_searched(mgeo, monkeypatch):
    reason = "a beam of 1 g carries nothing: relax it to 10 kg"
    monkeypatch.setattr(
        "stand_in.CantileverView.infeasibility_reasons", lambda self: [reason], raising=False
    )
    done = mgeo("solve", "cantilever", *SHORT, "--out", "a")
    assert done.exit_code == 3
    assert reason in done.stdout
    assert not Path("a").exists()
    done = mgeo("solve", "cantilever", *SHORT, "--out", "a", "--json")
    assert (done.exit_code, json.loads(done.stdout)) == (3, {"infeasibility_reasons": [reason]})


def test_screen_has_recommended_solution_and_five_of_the_front(mgeo):
    done = mgeo("solve", "cantilever", *SHORT, "--out", "a")
    F = read_run("a").outcome.F
    lines = done.stdout.splitlines()
    assert max(map(len, lines)) <= 80
    assert len(lines) <= 40
    rows = [line.split() for line in lines if re.match(r" *\d+  ", line)]
    assert len(rows) == 5
    numbers = [int(row[0]) for row in rows]
    np.testing.assert_allclose([float(row[-2]) for row in rows], F[numbers, 0], rtol=0.01)
    (knee,) = [number for number, row in zip(numbers, rows, strict=True) if "knee" in row]
    assert [line for line in lines if f"solution {knee}," in line]
    mass, deflection = F[knee]
    assert [line for line in lines if f"{mass:.3g} kg that sag {1000 * deflection:.3g} mm" in line]
    assert "mgeo report a" in done.stdout
    assert [line for line in lines if line == f"Warning: {len(F)} beams, of steel"]


def test_options_are_stored_in_the_configuration(mgeo):
    done = mgeo(
        *("solve", "cantilever", *REAL, "--set", "tau=2.5", "--walkers", "3"),
        *("--set", "sigma=0.05,0.1", "--set", "perturbation=range", "--set", "bounds=reflect"),
        *("--evaluations", "60", "--scenario", "heavy", "--out", "a"),
    )
    assert done.exit_code == 0, done.output
    data = json.loads(Path("a/run.json").read_text())["configuration"]
    assert data["parameters"] == {
        "sigma": [0.05, 0.1],
        "tau": 2.5,
        "n_walkers": 3,
        "perturbation": "range",
        "bounds": "reflect",
        "restart": "never",
        "patience": 50,
    }
    assert data["options"] == {"load": 2000.0}


def test_run_ends_after_max_time_and_can_be_resumed(mgeo):
    flags = ("--algorithm", "mgeo-real", "--walkers", "4", "--evaluations", 10**8)
    done = mgeo("solve", "cantilever", *flags, "--max-time", "0.003m", "--out", "a")
    assert done.exit_code == 0, done.output
    assert "stopped by --max-time after" in done.stdout.lower()
    assert done.stdout.splitlines()[-1].endswith("mgeo resume a")
    first = read_run("a").outcome
    assert (first.stop_reason, first.wall_time_s >= 0.18) == ("max_time", True)
    assert mgeo("resume", "a", "--max-time", 0.1).exit_code == 0
    assert read_run("a").outcome.n_evaluations > first.n_evaluations
    for text in ("soon", "0", "-1m", "inf"):
        result = mgeo("solve", "cantilever", "--max-time", text)
        assert result.exit_code == 2
        assert "expected a positive time, such as 90, 10m or 2h" in result.stderr


def test_arrays_of_the_problem_are_stored(mgeo, monkeypatch):
    def arrays(self):
        return {"volume": np.prod(self.X, axis=1)}

    monkeypatch.setattr("stand_in.CantileverView.arrays", arrays, raising=False)
    assert mgeo("solve", "cantilever", *SHORT, "--out", "a", "-q").exit_code == 0
    outcome = read_run("a").outcome
    assert np.array_equal(outcome.arrays["volume"], np.prod(outcome.X, axis=1))
    monkeypatch.setattr("stand_in.CantileverView.arrays", lambda self: 1 / 0)
    failed = mgeo("solve", "cantilever", *SHORT, "--out", "b", "-q")
    assert failed.exit_code == 2
    assert "arrays of problem Cantilever raised ZeroDivisionError" in failed.stderr
    assert len(read_run("b").outcome.F)


def test_existing_run_is_replaced_only_with_overwrite(mgeo):
    assert mgeo("solve", "cantilever", *SHORT, "--out", "a").exit_code == 0
    before = Path("a/run.json").read_bytes()
    Path("a/report.html").write_text("report of the previous run")
    result = mgeo("solve", "cantilever", *SHORT, "--out", "a", "--seed", 2)
    assert result.exit_code == 2
    assert result.stderr == "Error: a is not empty: choose another folder or allow --overwrite\n"
    assert Path("a/run.json").read_bytes() == before
    assert (
        mgeo("solve", "cantilever", *SHORT, "--out", "a", "--seed", 2, "--overwrite").exit_code == 0
    )
    assert read_run("a").configuration.seed == 2
    assert not Path("a/report.html").exists()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["cantilevr"], "there is no problem 'cantilevr'.*did you mean 'cantilever'"),
        (
            ["cantilever", *REAL, "--set", "sigma=1,x"],
            r"sigma\[1\] = 'x': expected a finite number > 0",
        ),
        (["cantilever", "--scenario", "no.toml"], "there is no scenario file no.toml"),
        (["cantilever", "--scenario", "no.tml"], "no.tml; presets of cantilever: .*heavy"),
        (["cantilever", "--out", "file"], "file is a file: expected a folder"),
        (["cantilever", "--set", "bits"], "--set bits: expected NAME=VALUE"),
    ],
)
def test_invalid_input_is_one_line_and_writes_nothing(mgeo, arguments, message):
    Path("file").write_text("")
    result = mgeo("solve", *arguments)
    assert result.exit_code == 2
    assert re.match(rf"Error: .*{message}", result.stderr), result.stderr
    assert result.stderr.count("\n") == 1
    assert result.stdout == ""
    assert [path.name for path in Path().iterdir()] == ["file"]


def test_failing_problem_is_one_line(mgeo, monkeypatch):
    def fail(self, X, out, *args, **kwargs):
        raise ValueError("singular matrix")

    monkeypatch.setattr("stand_in.Cantilever._evaluate", fail)
    failed = mgeo("solve", "cantilever", *SHORT, "--out", "a", "--quiet")
    assert failed.exit_code == 2
    assert re.fullmatch(
        r"Error: .*candidates failed, the first with ValueError: singular matrix.*",
        failed.stderr.splitlines()[-1],
    )
    assert not Path("a/run.json").exists()
    failed = mgeo("solve", "cantilever", *SHORT, "--out", "a", "--overwrite", "--debug")
    assert failed.exit_code == 2
    assert ", in fail\n" in failed.stderr


def test_failures_are_counted_by_cause(mgeo, monkeypatch):
    evaluate = resolve_name("stand_in:Cantilever._evaluate")

    def fail(self, X, out, *args, **kwargs):
        evaluate(self, X, out)
        out["F"][X[:, 0] > 0.045] = np.nan

    monkeypatch.setattr("stand_in.Cantilever._evaluate", fail)
    done = mgeo("solve", "cantilever", *SHORT, "--out", "a")
    assert done.exit_code == 0, done.output
    ((cause, n),) = read_run("a").outcome.failures.items()
    assert f"{n} evaluations failed" in done.stdout
    assert cause in done.stdout.replace("\n  ", " ")
    assert f"{n} failed" in done.stderr


@pytest.mark.slow
def test_run_without_feasible_solutions_reports_the_nearest(mgeo, monkeypatch):
    def infeasible(self, x, out, *args, **kwargs):
        out["F"], out["G"] = x**2, np.column_stack([x[:, 0] + 1.0, x[:, 1] - 1.0])

    monkeypatch.setattr("pymoo.problems.multi.BNH._evaluate", infeasible)
    for algorithm in ("nsga2", "mgeo-real"):
        flags = ("--algorithm", algorithm, "--evaluations", "400", "--out", algorithm)
        done = mgeo("solve", "bnh", *flags)
        assert done.exit_code == 3, done.output
        assert max(map(len, done.stdout.splitlines())) <= 80
        outcome = read_run(algorithm).outcome
        assert outcome.X.shape == (0, 2)
        # The first constraint function is x1 + 1, which is at least 1.
        nearest = outcome.nearest
        assert 1 <= len(nearest) <= 10
        assert nearest.violation[0, 0] == 1.0 + nearest.X[0, 0]
        relaxation = float(re.search(r"g1 by (\S+)\.", done.stdout)[1])
        assert 0.0 <= relaxation / nearest.violation[0, 0] - 1.0 < 0.01
    done = mgeo("solve", "bnh", *flags, "--overwrite", "--json")
    document = json.loads(done.stdout)
    assert (done.exit_code, document["n_nearest"] > 0, document["recommended"]) == (3, True, None)
    assert "nearest.csv" in document["files"]
    assert document["infeasibility"]["violations"]
    assert any("g1 by " in text for text in document["infeasibility"]["suggestions"])


class BoundedView(View):
    """View with a constraint that the search does not evaluate."""

    def constraints(self):
        bound = {"unit": "m", "bound_type": "at most", "bound_value": 0.5}
        columns = ["unit", "value", "bound_type", "bound_value", "margin"]
        return [
            pd.DataFrame(bound | {"value": x, "margin": 0.5 - x}, index=["width"])[columns]
            for x in self.X[:, 0]
        ]


class BoundedProblem(ZDT1):
    def view(self, X):
        return BoundedView(self, X)


def test_solutions_that_violate_a_constraint_are_marked(mgeo):
    name = f"{__name__}:{BoundedProblem.__name__}"
    arguments = ["solve", name, "--evaluations", 3000, "--out"]
    front = json.loads(mgeo(*arguments, "a", "--json").stdout)["front"]
    violated = [each["solution"] for each in front if each["violated"] == ["width"]]
    assert violated == [each["solution"] for each in front if each["f1"] > 0.5]
    assert 0 < len(violated) < len(front)
    text = mgeo(*arguments, "b").stdout
    assert re.findall(r"^ *(\d+)  [\w-]+ \* ", text, re.MULTILINE) == list(map(str, violated))
    assert re.search(r"^\* .* width", text, re.MULTILINE)
