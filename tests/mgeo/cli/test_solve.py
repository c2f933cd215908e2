import json
import re
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from mgeo.cli.options import parse_numbers, parse_settings
from mgeo.runs.algorithms import DEFAULT, ROBUST
from mgeo.runs.answer import default_solution
from mgeo.runs.prepare import PreparedRun, prepare
from mgeo.store.atomic import lock
from mgeo.store.run_folder import read_run

SHORT = ["--evaluations", "400", "--algorithm", "mgeo-real", "--runs", "4", "--sigma", "0.05"]
REAL = ["--algorithm", "mgeo-real"]


def test_the_directed_walkers_are_the_default(mgeo):
    assert mgeo("solve", "cantilever", "--evaluations", 64, "-q").exit_code == 0
    made = read_run("runs/cantilever-mgeo-directed-seed1").configuration
    prepared = prepare("cantilever", evaluations=64).configuration
    assert (made, made.algorithm) == (prepared, "mgeo-directed")


def test_a_run_is_written_and_can_be_made_again(mgeo):
    done = mgeo("solve", "cantilever", *SHORT, "--seed", 5)
    assert done.exit_code == 0, done.output
    folder = Path("runs/cantilever-mgeo-real-seed5")
    assert {path.name for path in folder.iterdir()} == {
        *("front.csv", "run.json", "front.html", "run.checkpoint")
    }
    run = read_run(folder)
    assert (run.outcome.status, run.outcome.evaluations) == ("finished", 400)
    again = PreparedRun.of(run.configuration).solve()
    assert np.array_equal(again.X, run.outcome.X)
    assert np.array_equal(again.F, run.outcome.F)
    assert "drawn by the plugin" in (folder / "front.html").read_text()


def test_a_robust_run_is_one_of_the_problem_that_the_problem_gives(mgeo):
    done = mgeo("solve", "cantilever", "--robust", "--evaluations", 160)
    assert done.exit_code == 0, done.output
    run = read_run("runs/cantilever-robust-mgeo-staged-seed1").configuration
    assert run.options == {"load": pytest.approx(1100.0)}
    assert run.algorithm == "mgeo-staged"
    mgeo("solve", "cantilever", "--robust", "--algorithm", "nsga2", *SHORT[:2], "--out", "b")
    assert read_run("b").configuration.algorithm == "nsga2"
    refused = mgeo("solve", "bnh", "--robust")
    assert refused.exit_code == 2
    assert refused.stderr == "Error: BNH has no robust(): expected a run without it\n"


def test_where_nothing_can_keep_all_limits_nothing_is_searched(mgeo, monkeypatch):
    why = "a beam of 1 g carries nothing: relax it to 10 kg"
    monkeypatch.setattr("stand_in.CantileverView.impossible", lambda self: [why], raising=False)
    done = mgeo("solve", "cantilever", *SHORT, "--out", "a")
    assert done.exit_code == 3
    assert done.stdout == f"nothing can keep all limits\n  {why}\n"
    assert not Path("a").exists()
    done = mgeo("solve", "cantilever", *SHORT, "--out", "a", "--json")
    assert (done.exit_code, json.loads(done.stdout)) == (3, {"impossible": [why]})


def test_what_a_problem_remarks_on_its_front_is_told(mgeo):
    done = mgeo("solve", "cantilever", *SHORT, "--out", "a")
    line = f"{len(read_run('a').outcome.F)} beams, of steel"
    assert done.stdout.splitlines()[2] == line
    mgeo("report", "a")
    assert f"<p>{line}</p>" in Path("a/report.html").read_text()


def test_the_table_shows_five_solutions_in_the_problems_terms(mgeo, monkeypatch):
    monkeypatch.setenv("COLUMNS", "400")  # a row is a line
    done = mgeo("solve", "cantilever", *SHORT, "--out", "a")
    F = read_run("a").outcome.F
    rows = {}
    for line in done.stdout.splitlines():
        name, *cells = re.split(r"  +", line.strip())
        rows[name] = cells
    assert len(rows["deflection [mm]"]) == 5
    mass = [float(cell) for cell in rows["mass [kg]"]]
    assert mass == sorted(mass)
    assert mass[0] == pytest.approx(F[:, 0].min(), rel=1e-4)
    assert 1e-3 * float(rows["deflection [mm]"][-1]) == pytest.approx(F[:, 1].min(), rel=1e-4)
    assert "knee" in done.stdout
    assert "a/front.html" in done.stdout


def test_the_first_line_is_what_a_person_asked(mgeo, monkeypatch):
    monkeypatch.setenv("COLUMNS", "400")  # a row is a line
    done = mgeo("solve", "cantilever", *SHORT, "--out", "a")
    from stand_in import Cantilever

    outcome, problem = read_run("a").outcome, Cantilever()
    row = default_solution(problem, outcome.F).row
    assert done.stdout.splitlines()[0] == (
        f"solution {row} of {len(outcome.F)}, knee: {problem.view(outcome.X[[row]]).answers()[0]}"
    )
    assert f"knee ({row})" in done.stdout.splitlines()[3]
    done = mgeo("solve", "sphere", "--algorithm", "nsga2", "--evaluations", "100", "--out", "b")
    (least,) = read_run("b").outcome.F.ravel()
    first = done.stdout.splitlines()[0]
    assert first == f"solution 0 of 1, best of the first objective: f1 {least:.5g}"


def test_flags_reach_the_configuration(mgeo):
    done = mgeo(
        *("solve", "cantilever", "--algorithm", "mgeo-real", "--tau", "2.5", "--runs", "3"),
        *("--sigma", "0.05,0.1"),
        *("--perturbation", "range", "--evaluations", "60", "--scenario", "heavy", "--out", "a"),
        *("--set", "bounds=reflect"),
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


def test_a_scenario_file_and_pymoos_algorithms(mgeo):
    Path("mine.toml").write_text("load = 750\n")
    done = mgeo(
        *("solve", "cantilever", "--scenario", "mine.toml", "--algorithm", "nsga3"),
        *("--population", "20", "--evaluations", "100"),
    )
    assert done.exit_code == 0, done.output
    configuration = read_run("runs/cantilever-nsga3-seed1").configuration
    assert (configuration.options, configuration.parameters) == (
        {"load": 750.0},
        {"population": 20},
    )


def test_without_the_optional_attributes_names_are_numbered_and_a_figure_is_drawn(mgeo):
    done = mgeo("solve", "zdt1", "--algorithm", "nsga2", "--evaluations", "200", "--out", "a")
    assert done.exit_code == 0, done.output
    assert "of the range this run saw" in done.stdout
    assert re.search(r"^x30( +[\d.e-]+){5}", done.stdout, re.MULTILINE)
    assert "Plotly.newPlot(" in Path("a/front.html").read_text()


@pytest.mark.parametrize(("problem", "columns"), [("sphere", 1), ("dtlz2", 5)])
def test_one_and_three_objectives(mgeo, problem, columns):
    done = mgeo("solve", problem, "--algorithm", "nsga2", "--evaluations", "300", "--out", "a")
    assert done.exit_code == 0, done.output
    assert re.search(rf"^x10( +[\d.e-]+){{{columns}}}$", done.stdout.rstrip(), re.MULTILINE)
    assert Path("a/front.html").exists()


def test_four_objectives_have_no_picture(mgeo):
    Path("four.toml").write_text("n_obj = 4\nn_var = 6\n")
    done = mgeo(
        *("solve", "dtlz2", "--scenario", "four.toml", "--algorithm", "nsga3"),
        *("--evaluations", "300", "--out", "a"),
    )
    assert done.exit_code == 0, done.output
    assert {path.name for path in Path("a").iterdir()} == {"front.csv", "run.json"}
    assert done.stdout.splitlines()[-1] == "written: a"


def test_quiet_prints_nothing(mgeo):
    done = mgeo("solve", "cantilever", *SHORT, "--quiet", "--out", "a")
    assert (done.exit_code, done.output) == (0, "")
    assert Path("a/run.json").exists()


def test_an_existing_run_is_refused_unless_told(mgeo):
    assert mgeo("solve", "cantilever", *SHORT, "--out", "a").exit_code == 0
    before = Path("a/run.json").read_bytes()
    Path("a/report.html").write_text("of the run before")
    refused = mgeo("solve", "cantilever", *SHORT, "--out", "a", "--seed", 2)
    assert refused.exit_code == 2
    assert refused.stderr == "Error: a is not empty: choose another folder or allow --overwrite\n"
    assert Path("a/run.json").read_bytes() == before
    assert (
        mgeo("solve", "cantilever", *SHORT, "--out", "a", "--seed", 2, "--overwrite").exit_code == 0
    )
    assert read_run("a").configuration.seed == 2
    assert not Path("a/report.html").exists()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["cantilevr"], "no problem is called 'cantilevr'.*did you mean 'cantilever'"),
        (["no-module"], "does not load: ModuleNotFoundError"),
        (["cantilever", "--algorithm", "nsga9"], "no algorithm is called 'nsga9'"),
        (
            ["cantilever", "--algorithm", "nsga2", "--tau", "2"],
            "--tau does not apply to nsga2, which takes --population: it is of mgeo-real, ",
        ),
        (
            ["cantilever", "--population", "20"],
            "--population does not apply to mgeo-directed, which takes --tau, --walkers, --set ext",
        ),
        (
            ["cantilever", "--sigma", "0.1"],
            "--sigma does not apply to mgeo-directed, .*: it is of mgeo-real, mgeo-real2$",
        ),
        (["cantilever", "--sigma", "1,x"], "--sigma = '1,x': expected a number or numbers"),
        (["cantilever", *REAL, "--sigma", "1,2,3"], "sigma of length 3"),
        (["cantilever", "--runs", "0"], "n_walkers = 0"),
        (["cantilever", *REAL, "--perturbation", "big"], "perturbation = 'big'"),
        (["cantilever", "--scenario", "huge"], "preset = 'huge': expected one of light, heavy"),
        (["cantilever", "--scenario", "no.toml"], "there is no scenario file no.toml"),
        (["cantilever", "--scenario", "1  2.toml"], "there is no scenario file 1  2.toml"),
        (["zdt1", "--scenario", "huge"], "unknown option 'preset' of problem 'zdt1'"),
        (["cantilever", "--out", "file"], "file is a file: expected a folder"),
        (["bnh", "--algorithm", "moead"], "does not treat constraints"),
    ],
)
def test_bad_input_is_one_line_and_leaves_nothing(mgeo, arguments, message):
    Path("file").write_text("")
    refused = mgeo("solve", *arguments)
    assert refused.exit_code == 2
    assert re.match(rf"Error: .*{message}", refused.stderr), refused.stderr
    assert refused.stderr.count("\n") == 1
    assert refused.stdout == ""
    assert [path.name for path in Path().iterdir()] == ["file"]


@pytest.mark.parametrize("arguments", [["--evaluations", "0"], ["--seed", "-1"], ["--nonsense"]])
def test_bad_usage_is_exit_code_2(mgeo, arguments):
    refused = mgeo("solve", "cantilever", *arguments)
    assert refused.exit_code == 2
    assert re.fullmatch(rf"Error: .*{arguments[0]}.* \(see mgeo solve --help\)\n", refused.stderr)
    assert refused.stdout == ""


def test_debug_shows_the_traceback(mgeo):
    refused = mgeo("solve", "cantilevr", "--debug")
    assert refused.exit_code == 2
    assert "Traceback (most recent call last)" in refused.stderr
    assert refused.stderr.splitlines()[-1].startswith("Error: no problem is called 'cantilevr'")


def test_a_failing_problem_is_one_line_and_leaves_no_folder(mgeo, monkeypatch):
    def fail(self, X, out, *args, **kwargs):
        raise ValueError("singular matrix")

    monkeypatch.setattr("stand_in.Cantilever._evaluate", fail)
    failed = mgeo("solve", "cantilever", *SHORT, "--out", "a", "--quiet")
    assert failed.exit_code == 2
    assert re.fullmatch(
        r"Error: .*candidates failed, the first with ValueError: singular matrix.*\n",
        failed.stderr,
    )
    assert not Path("a").exists()
    failed = mgeo("solve", "cantilever", *SHORT, "--out", "a", "--debug")
    assert failed.exit_code == 2
    assert ", in fail\n" in failed.stderr


def test_candidates_that_fail_are_counted_and_reported(mgeo, monkeypatch):
    import stand_in

    sound = stand_in.Cantilever._evaluate

    def fail(self, X, out, *args, **kwargs):
        sound(self, X, out)
        out["F"][X[:, 0] > 0.045] = np.nan
        if (X[:, 1] > 0.95).any():
            raise ValueError("singular matrix")

    monkeypatch.setattr("stand_in.Cantilever._evaluate", fail)
    for algorithm, flags in (("mgeo-real", SHORT), ("nsga2", SHORT[:2])):
        done = mgeo("solve", "cantilever", "--algorithm", algorithm, *flags, "--out", algorithm)
        assert done.exit_code == 0, done.output
        failures = json.loads(Path(algorithm, "run.json").read_text())["failures"]
        assert failures.keys() == {"F[0] = nan", "ValueError: singular matrix"}
        assert read_run(algorithm).outcome.failures == failures
        assert f"failed evaluations: {sum(failures.values())}; " in done.stdout
        assert f"singular matrix ({failures['ValueError: singular matrix']})" in done.stdout
        assert f"  failed {sum(failures.values())}  " in done.stderr
        assert (read_run(algorithm).outcome.X < [0.045, 0.95]).all()


def test_a_figure_that_fails_does_not_cost_the_run(mgeo, monkeypatch):
    def fail(self):
        raise ZeroDivisionError

    monkeypatch.setattr("stand_in.CantileverView.figures", fail)
    failed = mgeo("solve", "cantilever", *SHORT, "--out", "a", "--quiet")
    assert failed.exit_code == 2
    assert failed.stderr == "Error: figures of problem Cantilever raised ZeroDivisionError\n"
    assert read_run("a").outcome.evaluations == 400


@pytest.mark.slow
def test_a_run_without_feasible_solutions_says_so(mgeo, monkeypatch):
    def infeasible(self, x, out, *args, **kwargs):
        out["F"], out["G"] = x**2, np.column_stack([x[:, 0] + 1.0, x[:, 1] - 1.0])

    monkeypatch.setattr("pymoo.problems.multi.BNH._evaluate", infeasible)
    for algorithm in ("nsga2", "mgeo-real"):
        flags = ("--algorithm", algorithm, "--evaluations", "400", "--out", algorithm)
        done = mgeo("solve", "bnh", *flags)
        assert done.exit_code == 3, done.output
        assert "nothing that was found keeps all limits" in done.stdout
        outcome = read_run(algorithm).outcome
        assert outcome.X.shape == (0, 2)
        # the first constraint is x1 + 1, at least 1
        nearest = outcome.nearest
        assert len(nearest) == 10
        assert nearest.violation[0, 0] == 1.0 + nearest.X[0, 0]
        way = float(re.search(r"relax g1 by (\S+)", done.stdout)[1])
        assert 0.0 <= way / nearest.violation[0, 0] - 1.0 < 0.01
        html = Path(algorithm, "front.html").read_text()
        assert "Nothing that was found keeps all limits. These 10 come nearest." in html
        assert json.loads(Path(algorithm, "run.json").read_text())["nearest"] == 10
        report = mgeo("report", algorithm)
        assert report.exit_code == 0, report.output
        shown = Path(algorithm, "report.html").read_text()
        assert "<h2>Nothing that was found keeps all limits</h2>" in shown
        assert "no solution keeps all limits" in shown
    done = mgeo("solve", "bnh", *flags, "--overwrite", "--json")
    document = json.loads(done.stdout)
    assert (done.exit_code, document["nearest"], document["answer"]) == (3, 10, None)
    assert "nearest.csv" in document["files"]
    assert document["dead_end"]["exceeded"]
    assert document["dead_end"]["ways"][0].startswith("relax g1 by ")


@pytest.mark.slow
def test_what_is_nearest_survives_an_end_in_between(mgeo, monkeypatch):
    def infeasible(self, x, out, *args, **kwargs):
        out["F"], out["G"] = x**2, np.column_stack([2.0 + np.sin(9.0 * x[:, 0]), x[:, 1] + 1.0])

    monkeypatch.setattr("pymoo.problems.multi.BNH._evaluate", infeasible)
    flags = ("bnh", "--algorithm", "mgeo-real", "--runs", "4", "--sigma", "0.5", "-q")
    assert mgeo("solve", *flags, "--evaluations", "600", "--out", "whole").exit_code == 3
    assert mgeo("solve", *flags, "--evaluations", "200", "--out", "parts").exit_code == 3
    early = Path("parts/nearest.csv").read_bytes()
    assert mgeo("resume", "parts", "--evaluations", "600", "-q").exit_code == 3
    whole = Path("whole/nearest.csv").read_bytes()
    assert Path("parts/nearest.csv").read_bytes() == whole != early


def test_the_help_names_the_defaults(mgeo):
    text = " ".join(mgeo("solve", "--help").stdout.split())
    assert f"[default: {DEFAULT}, of a robust run {ROBUST}]" in text.replace("- ", "-")
    assert "`mgeo algorithms NAME`" in text


@pytest.mark.parametrize(("text", "sigma"), [("0.5", 0.5), ("1e-2, 3", [0.01, 3.0])])
def test_sigma(text, sigma):
    assert parse_numbers("--sigma", text) == sigma


def test_what_is_false_is_no_word_which_would_be_true():
    assert parse_settings(["elitist=false", "lazy=True"]) == {"elitist": False, "lazy": True}


def test_any_other_parameter_is_set_by_name(mgeo):
    done = mgeo(
        *("solve", "cantilever", "--algorithm", "mgeo-canonical", "--tau", "a-geo2", "--runs", "2"),
        *("--set", "bits=7,9", "--set", "coding=gray", "--set", "restart=archive"),
        *("--evaluations", "64", "--out", "a"),
    )
    assert done.exit_code == 0, done.output
    assert json.loads(Path("a/run.json").read_text())["configuration"]["parameters"] == {
        "tau": "a-geo2",
        "n_walkers": 2,
        "bits": [7, 9],
        "coding": "gray",
        "restart": "archive",
        "patience": 50,
    }


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        (["bits"], "--set bits: expected NAME=VALUE"),
        (["patience="], "--set patience=: expected NAME=VALUE"),
        (["tau=3"], "--set tau=3: expected --tau for this parameter"),
        (["patience=3", "patience=4"], "--set patience=4: patience is given twice"),
        (
            ["bits=8"],
            r"--set bits=... does not apply to mgeo-real, .* --set restart=..., --set pat.*: it is "
            "of mgeo-canonical, mgeo-var$",
        ),
        (["patience=2.5"], "patience = 2.5: expected an integer"),
        (["restart=often"], "restart = 'often': expected one of 'never'"),
    ],
)
def test_bad_settings_are_refused(mgeo, settings, message):
    flags = [part for setting in settings for part in ("--set", setting)]
    refused = mgeo("solve", "cantilever", *REAL, *flags)
    assert refused.exit_code == 2
    assert re.search(message, refused.stderr.strip().replace("\n", " "))


def test_a_run_that_ended_meanwhile_is_kept(mgeo, monkeypatch):
    """Another run gets the empty folder first, and ends before this one has a hold of it."""

    @contextmanager
    def late(folder):
        with lock(folder):
            (folder / "run.json").write_text("another")
            yield

    monkeypatch.setattr("mgeo.cli.solve.lock", late)
    refused = mgeo("solve", "cantilever", *SHORT, "--out", "a")
    assert refused.exit_code == 2
    assert refused.stderr.startswith("Error: a is not empty: choose another folder")
    assert [(path.name, path.read_text()) for path in Path("a").iterdir()] == [
        ("run.json", "another")
    ]
