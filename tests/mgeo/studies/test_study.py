import json
import os
import re
import signal
import subprocess
import sys
import time
from functools import partial

import numpy as np
import pandas as pd
import pytest
from pymoo.indicators.hv import HV
from pymoo.optimize import minimize
from typer.testing import CliRunner

from mgeo import MGEOReal
from mgeo.cli.app import app
from mgeo.studies import read_comparison, read_comparisons, read_study, run_study
from mgeo.studies.aggregation import compute_average_ranks, compute_friedman_test
from mgeo.studies.indicators import NoFeasibleSolutionError
from mgeo.studies.run import record_run
from mgeo.studies.study_file import parse_study
from mgeo.studies.tables import build_study_table

from .test_file import STUDIES

TWO_PROBLEMS = """
title = "Two <problems>"
description = "First.\\n\\nSecond & last."
evaluations = 120
seeds = 2
grid = 3
control = "nsga2 10"
[[problems]]
name = ["pymoo:zdt1", "pymoo:dtlz2"]
[[algorithms]]
name = ["nsga2", "random"]
label = "{name} {population}"
population = [10, 20]
"""
ONE_PROBLEM = TWO_PROBLEMS.replace('["pymoo:zdt1", "pymoo:dtlz2"]', '"cantilever"')


@pytest.mark.slow
def test_study_of_two_problems_writes_all_files(tmp_path):
    study = parse_study(TWO_PROBLEMS, tmp_path)
    out = tmp_path / "out"
    comparisons = run_study(study, out, progress=False)
    assert (out / "study.toml").read_text() == TWO_PROBLEMS
    values = pd.read_csv(out / "values.csv")
    recomputed = compute_average_ranks(values, study.control)
    pd.testing.assert_frame_equal(recomputed, pd.read_csv(out / "ranks.csv"))
    ranked = compute_friedman_test(values)
    assert (ranked.n_blocks, len(ranked.ranks)) == (2, 4)
    for label, result in comparisons.items():
        assert len(list((out / label / "runs").iterdir())) == 8
        n_indicators = 3 + 3  # Three indicators of the front and three of its parts.
        assert len(pd.read_csv(out / label / "tests.csv")) == 6 * n_indicators
        read = read_comparison(out / label)
        assert read.table.equals(result.table)
        assert read.format_overview().equals(result.format_overview())
        assert read.draw_figures() == result.draw_figures()
    data = json.loads((out / "dtlz2" / "provenance.json").read_text())
    assert data["problem"] == {"label": "dtlz2", "name": "pymoo:dtlz2", "options": {}}
    assert data["algorithms"]["random 20"] == {"name": "random", "parameters": {"population": 20}}
    assert (data["runs_finished"], data["runs_failed"]) == (8, 0)
    assert data["space"]["reference_point"] == [1.1] * 3
    stored = read_comparisons(out)
    assert list(stored) == list(comparisons)
    assert (out / "summary.tex").read_text() == build_study_table(stored).to_latex()
    assert (out / "summary.md").read_text().startswith(build_study_table(stored).to_markdown())
    with pytest.raises(FileNotFoundError, match="no comparison of one problem: see read_compar"):
        read_comparison(out)
    page = (out / "zdt1" / "report.html").read_text()
    for part in (
        "<h1>Two &lt;problems&gt;: zdt1</h1>",
        "<p>First.</p>",
        "<p>Second &amp; last.</p>",
    ):
        assert part in page
    assert page.count("Plotly.newPlot(") >= 6
    heading = "<h2>Comparison of nsga2 10 with every other algorithm</h2>"
    control_table = page.partition(heading)[2].partition("</table>")[0]
    for name in ("nsga2 20", "random 10", "random 20"):
        assert f">{name}</th>" in control_table
    link_pattern = r"<(?:script|link|img)[^>]*(?:src|href)=\"([^\"]*)\""
    assert set(re.findall(link_pattern, page)) == {"../plotly.min.js"}
    study_page = (out / "report.html").read_text()
    assert set(re.findall(link_pattern, study_page)) == {"plotly.min.js"}
    pages = re.findall(r"<a href=\"([^\"]*\.html)\"", study_page)
    assert pages == ["zdt1/report.html", "dtlz2/report.html"]
    assert '<a href="../report.html">' in page
    assert "p_holm_control" in pd.read_csv(out / "zdt1" / "tests.csv")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"pymoo:dtlz2"]', '"pymoo:bnh"]', "'moead' does not support the constraints"),
        ('"pymoo:dtlz2"]', '"pymoo:zdt2"]\nparts = [2.0, 1.0]', "zdt1: parts = "),
        (
            '"pymoo:dtlz2"]',
            '"pymoo:dtlz2"]\noptions = { x = inf }',
            "unknown option 'x' of problem 'pymoo:zdt1'",
        ),
    ],
)
def test_invalid_configuration_is_rejected_before_any_run(old, new, message, tmp_path):
    text = TWO_PROBLEMS.replace(old, new).replace("random", "moead")
    with pytest.raises((ValueError, TypeError), match=message):
        run_study(parse_study(text, tmp_path), tmp_path / "out", progress=False)
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
@pytest.mark.usefixtures("without_figures")
def test_problem_without_finished_run_does_not_stop_other_problems(tmp_path, monkeypatch):
    def fail_runs(task):
        return record_run(task) if task.problem.n_obj == 3 else "ValueError: no"

    monkeypatch.setattr("mgeo.studies.execute.run_task", fail_runs)
    study = parse_study(TWO_PROBLEMS, tmp_path).with_budget(60, 1)
    with pytest.raises(NoFeasibleSolutionError, match=r"^zdt1: all 4 runs failed.*ValueError: no$"):
        run_study(study, tmp_path / "out", progress=False)
    assert (tmp_path / "out" / "dtlz2" / "report.html").is_file()
    assert "zdt1: all 4 runs failed" in (tmp_path / "out" / "summary.md").read_text()
    assert list(read_comparisons(tmp_path / "out")) == ["dtlz2"]


@pytest.fixture
def run_command(tmp_path, monkeypatch, stand_in):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.toml").write_text(ONE_PROBLEM)
    return lambda *arguments: CliRunner().invoke(app, ["study", *map(str, arguments)])


@pytest.mark.usefixtures("without_figures")
def test_study_of_single_objective_problems(tmp_path):
    text = TWO_PROBLEMS.replace(
        '["pymoo:zdt1", "pymoo:dtlz2"]', '["pymoo:sphere", "pymoo:rastrigin"]'
    )
    text = text.replace("[10, 20]", "[10]")
    study = parse_study(text, tmp_path).with_budget(60, 1)
    run_study(study, tmp_path, n_jobs=1, progress=False)
    sphere = tmp_path / "sphere"
    assert list(read_comparison(sphere).format_overview().columns) == [
        "runs",
        "best value",
        "points",
    ]
    assert (
        "The result of a run is the smallest feasible value" in (sphere / "report.html").read_text()
    )
    assert list(read_comparisons(tmp_path)) == ["sphere", "rastrigin"]


@pytest.mark.slow
@pytest.mark.usefixtures("without_figures")
def test_command_continues_a_study_only_with_resume_option(run_command, tmp_path, monkeypatch):
    small = ("mine.toml", "--jobs", 1, "--seeds", 1, "--evaluations", 60)
    outcome = run_command(*small)
    assert outcome.exit_code == 0, outcome.output
    assert (tmp_path / "studies" / "mine" / "report.html").is_file()
    assert " ranks first " in outcome.stdout
    assert "studies/mine/report.html" in outcome.stdout
    assert max(map(len, outcome.stdout.splitlines())) <= 80
    refused = run_command(*small)
    assert refused.exit_code == 2
    (line,) = refused.stderr.splitlines()
    assert line.startswith("Error: studies/mine contains a study: continue it with --resume ")
    assert "mgeo[png]" not in outcome.stdout
    monkeypatch.setattr("mgeo.cli.study.find_spec", lambda name: None)
    resumed = run_command(*small, "--resume")
    assert "cantilever: reused 4 of 4 runs" in resumed.stderr
    assert "pip install 'mgeo[png]'" in resumed.stdout
    other = run_command(*small[:-1], 80, "--resume")
    assert other.exit_code == 2
    assert "contains another study: evaluations = 80, expected 60" in other.stderr
    quiet = run_command(*small, "--out", "quiet", "--quiet")
    assert (quiet.exit_code, quiet.output) == (0, "")


@pytest.mark.slow
@pytest.mark.usefixtures("without_figures")
def test_failed_runs_give_exit_code_3(run_command, monkeypatch):
    def fail_runs(task):
        return record_run(task) if task.seed == 1 else "ValueError: no"

    monkeypatch.setattr("mgeo.studies.execute.run_task", fail_runs)
    outcome = run_command("mine.toml", "--jobs", 1, "--evaluations", 60)
    assert outcome.exit_code == 3
    assert "4 runs failed; --resume repeats them" in outcome.stderr


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["none.toml"], "there is no study file none.toml"),
        (["mine.toml", "--cluster", "nonsense://"], "Error"),
    ],
)
def test_invalid_input_gives_one_line_error(run_command, arguments, message):
    outcome = run_command(*arguments)
    assert outcome.exit_code == 2
    assert message in outcome.stderr
    assert len(outcome.stderr.splitlines()) == 1


@pytest.mark.slow
def test_interrupted_or_killed_study_can_be_resumed(tmp_path, stand_in_environment, stand_in):
    (tmp_path / "slow.toml").write_text(ONE_PROBLEM.replace('"cantilever"', '"slow-cantilever"'))
    command = [sys.executable, "-m", "mgeo", "study", "slow.toml", "--jobs", "1"]
    slow_environment = stand_in_environment | {"STAND_IN_SECONDS": "0.3"}
    runs = tmp_path / "studies" / "slow" / "runs"

    def files():
        return {path: path.stat().st_mtime_ns for path in runs.glob("*.npz")}

    def start(*more, until):
        # The signal is ignored in processes started by nohup.
        restore_signal = partial(signal.signal, signal.SIGINT, signal.SIG_DFL)
        settings = {
            "cwd": tmp_path,
            "env": slow_environment,
            "text": True,
            "stderr": subprocess.PIPE,
        }
        process = subprocess.Popen([*command, *more], preexec_fn=restore_signal, **settings)
        deadline = time.monotonic() + 300
        while len(files()) < until:
            assert process.poll() is None
            assert time.monotonic() < deadline
            time.sleep(0.01)
        return process

    interrupted = start(until=2)
    interrupted.send_signal(signal.SIGINT)
    _, errors = interrupted.communicate(timeout=300)
    assert interrupted.returncode == 130
    assert "interrupted; --resume continues with the runs in studies/slow" in errors
    stored_files = files()
    killed = start("--resume", until=len(stored_files) + 1)
    os.kill(killed.pid, signal.SIGKILL)
    killed.communicate(timeout=300)
    stored_files |= files()
    assert len(stored_files) < 8
    outcome = subprocess.run(
        [*command, "--resume"],
        cwd=tmp_path,
        env=stand_in_environment,
        text=True,
        capture_output=True,
        check=True,
    )
    assert f"reused {len(stored_files)} of 8 runs" in outcome.stderr
    assert {path: when for path, when in files().items() if path in stored_files} == stored_files
    run_study(parse_study(ONE_PROBLEM, tmp_path), tmp_path / "whole", n_jobs=1, progress=False)
    written = (tmp_path / "studies" / "slow" / "table.csv").read_text()
    assert written == (tmp_path / "whole" / "table.csv").read_text()


def test_folder_without_comparison_is_named(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"holds no comparison: there is no provenance"):
        read_comparison(tmp_path)
    (tmp_path / "provenance.json").write_text('{"problem": {"name": "pymoo:zdt1", "options": {}}}')
    with pytest.raises(ValueError, match=r"provenance.json: .*'space'"):
        read_comparison(tmp_path)


@pytest.mark.slow
@pytest.mark.usefixtures("without_figures")
def test_reduced_study_of_published_table(tmp_path):
    pytest.importorskip("mgeo_attitude")
    study = read_study(STUDIES / "table3.toml").with_budget(360, 1)
    (comparison,) = run_study(study, tmp_path / "out", n_jobs=2, progress=False).values()
    final = comparison.select_final_rows()
    assert len(final) == 6
    both = final["points, first orbit"] + final["points, second orbit"]
    assert both.tolist() == final["points"].tolist()
    assert (comparison.space.origin, comparison.space.reference_point.tolist()) == (
        "problem",
        [1.0, 1.0],
    )
    # The archive that minimize returns for MGEO_real has the same points.
    row = final[final["algorithm"] == "σ = 1.0"].iloc[0]
    result = minimize(comparison.problem, MGEOReal(sigma=1.0), ("n_eval", 360), seed=1)
    assert row["points"] == len(result.F)
    area = HV(ref_point=np.ones(2))(comparison.problem.map_to_indicator_space(result.F))
    assert row["hypervolume"] == pytest.approx(area, rel=1e-12)
    page = (tmp_path / "out" / "report.html").read_text()
    assert (
        study.published.source not in page.partition("About this study")[0]
    )  # The published values have another budget.
