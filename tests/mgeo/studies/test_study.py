import json
import os
import re
import signal
import subprocess
import sys
import time
from dataclasses import replace
from functools import partial
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from pymoo.indicators.hv import HV
from pymoo.optimize import minimize
from scipy import stats
from typer.testing import CliRunner

from mgeo import MGEOReal
from mgeo.cli.app import app
from mgeo.studies.comparison import Comparison, problems_table
from mgeo.studies.conclusions import against, conclusions, control_table, published_table
from mgeo.studies.file import parse_study, read_study
from mgeo.studies.indicators import NothingToCompareError
from mgeo.studies.labels import folder_name
from mgeo.studies.pooled import friedman_over_problems, ranks_over_problems
from mgeo.studies.results import FailedRunsWarning
from mgeo.studies.run import Failure, record
from mgeo.studies.schema import PublishedTable
from mgeo.studies.stored import read_comparison, read_comparisons
from mgeo.studies.study import run_study

from .samples import VALUES, comparison
from .test_file import STUDIES

TWO = """
title = "Two <problems>"
about = "First.\\n\\nSecond & last."
evaluations = 120
seeds = 2
grid = 3
[[problems]]
name = ["pymoo:zdt1", "pymoo:dtlz2"]
[[algorithms]]
name = ["nsga2", "random"]
label = "{name} {population}"
population = [10, 20]
"""
ONE = TWO.replace('["pymoo:zdt1", "pymoo:dtlz2"]', '"cantilever"')
FILES = {
    "table.csv",
    "final.csv",
    "fronts.csv",
    "runs.csv",
    "tests.csv",
    "summary.md",
    "summary.tex",
    "report.html",
    "provenance.json",
}


def names(folder):
    return {path.name for path in folder.iterdir()}


@pytest.mark.campaign
@pytest.mark.slow
def test_a_study_of_two_problems(tmp_path, monkeypatch):
    study = parse_study(TWO, tmp_path)
    found = run_study(study, tmp_path / "out", progress=False)
    out = tmp_path / "out"
    assert names(out) == {
        "runs",
        "zdt1",
        "dtlz2",
        "summary.md",
        "summary.tex",
        "summary.csv",
        "values.csv",
        "ranks.csv",
        "targets.csv",
        "plotly.min.js",
        "report.html",
        "study.toml",
        "study.json",
    }
    assert (out / "study.toml").read_text() == TWO
    assert len(list((out / "runs").iterdir())) == 16
    values = pd.read_csv(out / "values.csv")
    again = ranks_over_problems(values, study.control)
    pd.testing.assert_frame_equal(again, pd.read_csv(out / "ranks.csv"))
    for label, result in found.items():
        assert names(out / label) == FILES
        pd.testing.assert_frame_equal(pd.read_csv(out / label / "table.csv"), result.table)
        assert len(pd.read_csv(out / label / "final.csv")) == 8
        assert len(pd.read_csv(out / label / "tests.csv")) == 6 * (3 + 3)  # and parts
        assert len((out / label / "summary.md").read_text().splitlines()) == 2 + 4 + 2
    page = (out / "zdt1" / "report.html").read_text()
    assert "<h1>Two &lt;problems&gt;</h1>\n<p>First.</p>\n<p>Second &amp; last.</p>" in page
    assert page.count("Plotly.newPlot(") >= 6
    assert "Kruskal-Wallis test of all algorithms at once: p = " in page
    assert "<h2>By parts of the front</h2>" in page
    loaded = r"<(?:script|link|img)[^>]*(?:src|href)=\"([^\"]*)\""
    assert set(re.findall(loaded, page)) == {"../plotly.min.js"}
    whole = (out / "report.html").read_text()
    assert set(re.findall(loaded, whole)) == {"plotly.min.js"}
    assert len(page) < 1e6  # the library is in it no more
    data = json.loads((out / "dtlz2" / "provenance.json").read_text())
    assert data["problem"] == {"label": "dtlz2", "name": "pymoo:dtlz2", "options": {}}
    assert data["algorithms"]["random 20"] == {"name": "random", "parameters": {"population": 20}}
    assert (data["runs_finished"], data["runs_failed"]) == (8, 0)
    assert data["space"]["reference_point"] == [1.1] * 3
    for label, result in found.items():
        again = read_comparison(out / label)
        assert again.table.equals(result.table)
        assert again.overview().equals(result.overview())
        assert again.figures() == result.figures()
    every = read_comparisons(out)
    assert list(every) == list(found)
    tables = problems_table(every)
    assert (out / "summary.tex").read_text() == tables.latex()
    assert (out / "summary.md").read_text() == tables.markdown()
    with pytest.raises(FileNotFoundError, match="no comparison of one problem: see read_compar"):
        read_comparison(out)
    ranked = friedman_over_problems(values)
    assert (ranked.blocks, len(ranked.ranks)) == (2, 4)
    # all runs are on disk: nothing is run again, and the tables come out the same
    monkeypatch.setattr("mgeo.studies.dispatch.run", None)
    monkeypatch.setattr(Comparison, "figures", lambda self: {})  # these are not looked at again
    before = (out / "zdt1" / "table.csv").read_bytes()
    run_study(study, out, progress=False)
    assert (out / "zdt1" / "table.csv").read_bytes() == before


@pytest.mark.slow
def test_a_study_of_one_problem_needs_no_folders_below(tmp_path, stand_in):
    study = parse_study(ONE, tmp_path).reduced(60, 1)
    run_study(study, tmp_path / "out", progress=False)
    assert names(tmp_path / "out") == FILES | {"runs", "study.toml", "study.json"}
    data = json.loads((tmp_path / "out" / "provenance.json").read_text())
    assert data["versions"]["stand-in"] == "1.2.3"
    assert {"python", "mgeo", "pymoo", "numpy", "scipy", "moocore"} < data["versions"].keys()
    runs = pd.read_csv(tmp_path / "out" / "runs.csv")
    assert runs["versions"].str.contains("stand-in 1.2.3").all()
    assert data["space"]["origin"] == "problem"


def test_what_cannot_be_built_is_found_before_any_run(tmp_path):
    study = parse_study(
        TWO.replace("pymoo:dtlz2", "pymoo:bnh").replace("random", "moead"), tmp_path
    )
    with pytest.raises(ValueError, match="'moead' does not treat constraints"):
        run_study(study, tmp_path / "out", progress=False)
    assert not (tmp_path / "out").exists()


def test_parts_that_cannot_be_are_found_before_any_run(tmp_path):
    study = parse_study(f"{TWO}[[problems]]\nname = 'pymoo:zdt2'\nparts = [2.0, 1.0]\n", tmp_path)
    with pytest.raises(ValueError, match="zdt2: parts = "):
        run_study(study, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_folder_that_cannot_be_written_is_found_before_any_run(tmp_path, monkeypatch):
    def full(folder):
        raise OSError(28, "No space left on device", str(folder))

    monkeypatch.setattr("mgeo.studies.study.check_writable", full)
    monkeypatch.setattr("mgeo.studies.study.compare", lambda *arguments, **options: 1 / 0)
    with pytest.raises(OSError, match="No space left on device"):
        run_study(parse_study(TWO, tmp_path), tmp_path / "out", progress=False)


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
def test_a_problem_without_a_result_does_not_stop_the_others(tmp_path, monkeypatch):
    def failing(task):
        return record(task) if task.problem.n_obj == 3 else Failure("ValueError: no")

    monkeypatch.setattr("mgeo.studies.dispatch.run", failing)
    study = parse_study(TWO, tmp_path).reduced(60, 1)
    with pytest.raises(NothingToCompareError, match=r"^zdt1: all 4 runs failed.*ValueError: no$"):
        run_study(study, tmp_path / "out", progress=False)
    assert (tmp_path / "out" / "dtlz2" / "report.html").is_file()
    assert "dtlz2" in (tmp_path / "out" / "summary.md").read_text()


@pytest.mark.campaign
@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
def test_who_fails_on_a_problem_is_last_there_and_it_is_said(tmp_path, monkeypatch):
    def failing(task):
        bad = task.problem.n_obj == 3 and type(task.algorithm).__name__ == "NSGA2"
        return Failure("ValueError: no") if bad and task.algorithm.pop_size == 10 else record(task)

    monkeypatch.setattr("mgeo.studies.dispatch.run", failing)
    message = "nsga2 10 on dtlz2: 2 of 2 runs failed, the first with ValueError: no"
    with pytest.warns(FailedRunsWarning, match=f"^{message}$"):
        run_study(parse_study(TWO, tmp_path), tmp_path, progress=False)
    ranks = pd.read_csv(tmp_path / "ranks.csv").query("evaluations == 120 and variables == 0")
    assert len(ranks) == 4
    values = pd.read_csv(tmp_path / "values.csv").query("problem == 'dtlz2'")
    assert (values["nsga2 10"] == -np.inf).all()
    assert message in (tmp_path / "summary.md").read_text()
    page = (tmp_path / "report.html").read_text()
    assert message in page
    assert "nsga2 10  \\u003cb\\u003e" in page  # in the figure


def test_the_conclusions_name_the_best_its_rivals_and_what_points_say():
    made = comparison()
    made.table.loc[made.table["algorithm"] == "B", "points"] = 99
    assert conclusions(made) == [
        "By hypervolume, A_1 ranks first: 0.60 ± 0.10, then C: 0.45 ± 0.23.",
        "It is not significantly different from any other (A from 0.72 to 1.00). A is the "
        "probability that a run of it beats one of the other; Mann-Whitney test with Holm's "
        "correction for all pairs, 5 %.",
        "By IGD+, A_1 ranks first, too.",
        "By additive epsilon, A_1 ranks first, too.",
        "The most points are on the fronts of B: 99 on average. By hypervolume it is number 3 of "
        "3: points say how finely a front was traced, not how far it reaches.",
    ]


def test_the_conclusions_say_where_other_indicators_disagree():
    made = comparison()
    values = {"A_1": (0.7, 0.3, 0.2), "B": (0.1, 0.1, 0.3), "C": (0.2, 0.5, 0.21)}
    rows = [
        {"algorithm": name, "seed": seed, "evaluations": 100, "points": 9}
        | dict(
            zip(("hypervolume", "igd_plus", "epsilon"), np.add(v, 0.004 * (seed - 1)), strict=True)
        )
        for name, v in values.items()
        for seed in range(1, 9)
    ]
    found = conclusions(Comparison(**{**vars(made), "table": pd.DataFrame(rows)}))
    assert found[2:4] == [
        "By IGD+, B ranks first: 0.1140 ± 0.0098, and A_1 number 2: 0.3140 ± 0.0098; B is "
        "significantly better (A = 1.00).",
        "By additive epsilon, A_1 ranks first, too.",
    ]
    table = pd.DataFrame(rows)
    chosen = table["algorithm"] == "A_1"
    table.loc[chosen, "epsilon"] += 0.011  # behind C by a little
    found = conclusions(Comparison(**{**vars(made), "table": table}))
    assert found[3] == (
        "By additive epsilon, C ranks first: 0.2240 ± 0.0098, and A_1 number 2: 0.2250 ± 0.0098; "
        "these two are not significantly different."
    )


def test_the_conclusions_part_rivals_from_others():
    made = comparison()
    spread = {"A_1": 0.7, "B": 0.1, "C": 0.69}
    rows = [
        {"algorithm": name, "seed": seed, "evaluations": 100, "points": 9, "hypervolume": v}
        for name, value in spread.items()
        for seed, v in enumerate(value + 0.01 * np.arange(8), 1)
    ]
    table = pd.DataFrame(rows).assign(igd_plus=0.5, epsilon=0.5)
    found = conclusions(Comparison(**{**vars(made), "table": table}))
    assert found[1].startswith(
        "It is not significantly different from C (A = 0.62); it is significantly better than all "
        "others (A = 1.00). "
    )
    table = table.query("algorithm != 'C'")
    two = Comparison(**{**vars(made), "table": table, "algorithms": ("A_1", "B")})
    assert conclusions(two)[1].startswith(
        "It is significantly better than every other (A = 1.00). "
    )
    one = Comparison(**{**vars(made), "table": table.query("algorithm == 'B'")})
    assert conclusions(one) == []


def final(values, points=9):
    """A comparison of hypervolumes only, by algorithm; 0 is a run without a front."""
    rows = [
        {"algorithm": name, "seed": seed, "evaluations": 100, "hypervolume": v}
        | {"igd_plus": 1 - v if v else np.inf, "epsilon": 1 - v if v else np.inf}
        | {"points": points if v else 0}
        for name, column in values.items()
        for seed, v in enumerate(column, 1)
    ]
    table = pd.DataFrame(rows)
    return Comparison(**{**vars(comparison()), "table": table, "algorithms": tuple(values)})


def test_the_conclusions_correct_for_the_rivals_of_a_control_alone():
    # of A and B p = 60 / 3432, the least of three pairs: twice is below 5 %, three times is not
    steps = np.arange(7) / 100
    made = final({"A": 0.535 + steps, "B": 0.5 + steps, "C": 0.5175 + steps})
    p = made.tests().pairs.set_index(["a", "b"])["p"]
    assert p["A", "B"] == pytest.approx(60 / 3432)
    assert "It is not significantly different from any other" in conclusions(made)[1]
    found = conclusions(made, "A")
    assert found[1].startswith(
        "It is not significantly different from C (A = 0.69); it is significantly better than all "
        "others (A = 0.88). "
    )
    assert "correction for its rivals, 5 %" in found[1]
    assert conclusions(made, "B") == conclusions(made)  # the first was not named before
    # by another indicator, B is ahead of the control
    swapped = made.table["algorithm"].replace({"A": "B", "B": "A"})
    turned = made.table.assign(algorithm=swapped).sort_values(["algorithm", "seed"])
    made.table["igd_plus"] = turned["igd_plus"].to_numpy()
    assert conclusions(made)[2].endswith("these two are not significantly different.")
    assert conclusions(made, "A")[2].endswith("B is significantly better (A = 0.88).")


def test_the_conclusions_say_in_which_part_another_one_is_ahead():
    steps = np.arange(8) / 1000
    made = final({"A": 0.60 + steps, "B": 0.55 + steps, "C": 0.50 + steps})
    assert not any("part of the front" in text for text in conclusions(made))  # not measured
    made = replace(made, space=replace(made.space, parts=(3.0,), cuts=(0.5,)))
    total = made.table["hypervolume"]
    ahead = 0.2 + 0.1 * (made.table["algorithm"] == "B") + total / 100
    made.table["hypervolume_1"], made.table["hypervolume_2"] = ahead, total - ahead
    assert "hypervolume, f1 to 3" in made.overview()
    assert (
        "In a part of the front are significantly better than A: B by hypervolume, f1 to 3."
        in conclusions(made)
    )
    of_parts = control_table(made, "A", made.parts)
    assert of_parts.loc["B", "hypervolume, f1 to 3: A"] == "0.000"
    assert of_parts.loc["B", "hypervolume, f1 from 3: A"] == "1.000"
    made.table["hypervolume_1"], made.table["hypervolume_2"] = 0.1, total - 0.1
    assert "In no part of the front is another one significantly better than A." in conclusions(
        made
    )


def test_a_front_in_one_run_of_ten_is_not_the_best():
    made = final({"always": 0.50 + 0.001 * np.arange(10), "once": [0.0] * 9 + [0.9]})
    for indicator in (None, "igd_plus", "epsilon"):
        assert made.order(indicator) == ["always", "once"]
    found = conclusions(made)
    assert (
        found[0] == "By hypervolume, always ranks first: 0.5045 ± 0.0030, then once: 0.09 ± 0.28."
    )
    assert found[1].startswith("It is significantly better than every other (A = 0.90). ")
    assert found[2:4] == [
        f"By {name}, always ranks first, too." for name in ("IGD+", "additive epsilon")
    ]
    assert made.overview().loc["once", "IGD+"] == "inf"
    assert made.to_latex().count(r"\textbf") == 3 + len(made.parts)
    assert r"always & 10 & \textbf{0.5045" in made.to_latex()


def test_what_the_test_finds_worse_is_not_called_best_for_its_mean():
    # four runs of twenty are far ahead, the others behind: A = 0.2 with the higher mean
    low, high = 0.40 + 0.001 * np.arange(16), 0.9 + 0.001 * np.arange(4)
    made = final({"lucky": [*low, *high], "steady": 0.42 + 0.001 * np.arange(20)})
    pair = made.tests().pairs.iloc[0]
    assert pair["A"] == pytest.approx(0.2)
    assert pair["p_holm"] < 0.002
    assert made.summary()[("hypervolume", "mean")].idxmax() == "lucky"
    assert made.order() == ["steady", "lucky"]
    found = conclusions(made)
    assert found[0].startswith("By hypervolume, steady ranks first: 0.4295 ± 0.0059, then lucky: ")
    assert found[1].startswith("The best mean is that of lucky, 0.51 ± 0.20; ")
    assert found[2].startswith("It is significantly better than every other (A = 0.80). ")


def test_conclusions_name_what_beats_the_first():
    """Ranks among all runs need not agree with every pair: where some runs fall behind all, the
    others may be ahead by little, and often.
    """
    few = 0.001 * np.arange(20)
    made = final(
        {
            "steady": 0.70 + few,
            "risky": [*(0.10 + few[:4]), *(0.75 + few[:16])],
            **{f"third {i}": 0.60 + few for i in range(3)},
        }
    )
    assert made.order()[:2] == ["steady", "risky"]
    found = conclusions(made)
    assert " ranks first: " in found[0]
    assert found[1].startswith(
        "It is significantly better than all others (A = 1.00); it is significantly worse than "
        "risky (A = 0.20). "
    )


def test_published_values_are_compared_with_ours():
    study = parse_study(
        TWO.replace('label = "{name} {population}"', 'label = "A_1"')
        .replace('["nsga2", "random"]', '"nsga2"')
        .replace("[10, 20]", "10")
        + '[published]\nsource = "x"\ntable = { A_1 = { points = 7, other = 1 } }',
        None,
    )
    table = published_table(study, comparison())
    assert table.loc["A_1"].tolist() == ["7", "20 ± 10", "1", "0.60 ± 0.10"]
    assert table.loc["B"].tolist() == ["-", "20 ± 10", "-", "0.20 ± 0.10"]


def test_a_control_is_corrected_for_its_rivals_alone():
    made = comparison()
    rows = against(made, "B", control=True)
    assert list(rows.index) == ["A_1", "C"]
    # of three and three values, all apart, 2 of 20 orders: for two rivals, not for three pairs
    tied = stats.mannwhitneyu(VALUES["B"], VALUES["C"]).pvalue
    assert tied > 0.2
    assert rows["p_holm"].tolist() == pytest.approx([2 * 0.1, tied])
    assert against(made, "B")["p_holm"].tolist() == pytest.approx([3 * 0.1, 2 * tied])
    table = control_table(made, "B", made.indicators)
    assert table["hypervolume: A"].tolist() == ["0.000", f"{1.5 / 9:.3f}"]
    assert table["IGD+: p (Holm)"].tolist() == ["0.2", f"{tied:.2g}"]
    assert table.index.name == "B against"


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
def test_the_page_of_a_study_with_a_control_shows_it_against_all(tmp_path):
    text = TWO.replace("grid = 3", 'grid = 3\ncontrol = "nsga2 10"')
    text = text.replace(', "pymoo:dtlz2"', "")
    run_study(parse_study(text, None), tmp_path)
    page = (tmp_path / "report.html").read_text()
    below = page.partition("<h2>nsga2 10 against every other</h2>")[2].partition("</table>")[0]
    assert all(f"<td>{name}</td>" in below for name in ("nsga2 20", "random 10", "random 20"))


def test_published_indicators_are_named_as_in_the_table():
    published = PublishedTable(source="x", table={"A_1": {"igd_plus": 0.5}})
    table = published_table(SimpleNamespace(published=published), comparison())
    assert table.loc["A_1"].tolist() == ["0.5", "0.40 ± 0.10", "0.60 ± 0.10"]


@pytest.mark.campaign
@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
def test_one_problem_with_other_options_is_another_problem(tmp_path):
    text = TWO.replace(
        '["pymoo:zdt1", "pymoo:dtlz2"]',
        '"pymoo:dtlz2"\noptions = { n_obj = 2 }\n[[problems]]\nname = "pymoo:dtlz2"\n'
        "options = { n_obj = 3 }",
    )
    found = run_study(parse_study(text, tmp_path).reduced(40, 1), tmp_path / "out", progress=False)
    assert [made.problem.n_obj for made in found.values()] == [2, 3]
    assert list(found) == ["dtlz2, n_obj = 2", "dtlz2, n_obj = 3"]
    for label, made in found.items():
        again = read_comparison(tmp_path / "out" / folder_name(label))
        assert again.table.equals(made.table)
    page = (tmp_path / "out" / "report.html").read_text()
    assert 'href="dtlz2-n_obj-2~' in page


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
def test_a_study_of_one_objective(mgeo, tmp_path):
    text = TWO.replace('["pymoo:zdt1", "pymoo:dtlz2"]', '["pymoo:sphere", "pymoo:rastrigin"]')
    (tmp_path / "single.toml").write_text(text)
    done = mgeo("single.toml", "--jobs", 1)
    assert done.exit_code == 0, done.output
    out = tmp_path / "studies" / "single"
    assert names(out / "sphere") == FILES
    again = read_comparison(out / "sphere")
    assert list(again.overview().columns) == ["runs", "best value", "points"]
    assert again.order() == read_comparison(out / "sphere").order()
    assert (
        "Of a run counts the least feasible value" in (out / "sphere" / "report.html").read_text()
    )
    assert "sphere (best value)" in (out / "summary.md").read_text()
    assert "By best value, " in done.stdout
    assert "front" not in done.stdout
    data = json.loads((out / "sphere" / "provenance.json").read_text())
    assert data["space"] == {"origin": "objective"}
    data["space"] = {"origin": "union"}
    (out / "sphere" / "provenance.json").write_text(json.dumps(data))
    with pytest.raises(ValueError, match=r"space\.origin = 'union' with 1 objective"):
        read_comparison(out / "sphere")


@pytest.mark.campaign
@pytest.mark.slow
@pytest.mark.usefixtures("undrawn", "stand_in")
def test_scenarios_of_like_names_have_their_own_folders(tmp_path):
    for name, load in (("a.b", 1.0), ("a-b", 2.0), ("a b", 3.0)):
        (tmp_path / f"{name}.toml").write_text(f"load = {load}")
    text = ONE.replace(
        '"cantilever"', '"cantilever"\nscenario = ["a.b.toml", "a-b.toml", "a b.toml"]'
    )
    found = run_study(parse_study(text, tmp_path).reduced(40, 1), tmp_path / "out", progress=False)
    folders = [folder_name(label) for label in found]
    assert len(set(folders)) == 3
    kept = [read_comparison(tmp_path / "out" / folder).problem.load for folder in folders]
    assert kept == [1.0, 2.0, 3.0]


@pytest.fixture
def mgeo(tmp_path, monkeypatch, stand_in):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.toml").write_text(ONE)
    return lambda *arguments: CliRunner().invoke(app, ["study", *map(str, arguments)])


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
def test_the_command_runs_a_file_and_says_what_it_found(mgeo, tmp_path):
    done = mgeo("mine.toml", "--jobs", 1, "--seeds", 1, "--evaluations", 60)
    assert done.exit_code == 0, done.output
    assert names(tmp_path / "studies" / "mine") == FILES | {"runs", "study.toml", "study.json"}
    assert " ranks first: " in done.stdout
    assert "written: studies/mine/report.html" in done.stdout
    assert "cantilever: 4 runs, 0 of them found on disk" in done.stderr
    again = mgeo(
        "mine.toml", "--jobs", 1, "--seeds", 2, "--evaluations", 60, "--out", "studies/mine"
    )
    assert "cantilever: 8 runs, 4 of them found on disk" in again.stderr
    quiet = mgeo("mine.toml", "--jobs", 1, "--seeds", 1, "--evaluations", 60, "--quiet")
    assert (quiet.exit_code, quiet.output) == (0, "")


@pytest.mark.campaign
@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
@pytest.mark.filterwarnings("default")
def test_runs_that_are_not_used_are_one_note(mgeo, tmp_path):
    runs = tmp_path / "studies" / "mine" / "runs"
    runs.mkdir(parents=True)
    (runs / "NSGA2-0123456789ab-seed1.npz").write_bytes(b"old")
    (tmp_path / "mine.toml").write_text(TWO)
    for more in ((), ("--dry-run",)):
        done = mgeo("mine.toml", "--jobs", 1, "--seeds", 1, "--evaluations", 60, *more)
        assert done.exit_code == 0, done.output
        notes = [line for line in done.stderr.splitlines() if line.startswith("Note: ")]
        assert notes == [
            "Note: studies/mine/runs holds runs of an earlier mgeo (1): they are not used"
        ]


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
def test_failed_runs_give_an_exit_code(mgeo, monkeypatch):
    def failing(task):
        return record(task) if task.seed == 1 else Failure("ValueError: no")

    monkeypatch.setattr("mgeo.studies.dispatch.run", failing)
    done = mgeo("mine.toml", "--jobs", 1, "--evaluations", 60)
    assert done.exit_code == 3
    assert "4 runs failed; the same command makes them again" in done.stderr


@pytest.mark.campaign
@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
def test_a_terminal_of_ascii_shows_all(mgeo, tmp_path):
    text = ONE.replace("{name} {population}", "{name} σ = {population}")
    (tmp_path / "mine.toml").write_text(text.replace("Two", "Größe"), encoding="utf-8")
    ascii = CliRunner(charset="ascii")
    small = ["study", "mine.toml", "--jobs", "1", "--seeds", "1", "--evaluations", "60"]
    done = ascii.invoke(app, small)
    assert done.exit_code == 0, done.output
    assert r"nsga2 \u03c3 = 10" in done.stdout
    assert "written: studies/mine/report.html" in done.stdout
    dry = ascii.invoke(app, [*small, "--dry-run"])
    assert dry.exit_code == 0, dry.output
    assert r"Gr\xf6\xdfe" in dry.stdout
    solved = ascii.invoke(app, ["solve", "cantilever", "--evaluations", "60", "--out", "größer"])
    assert solved.exit_code == 0, solved.output
    assert r"gr\xf6\xdfer" in solved.stdout


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["none.toml"], "there is no study file none.toml"),
        (["mine.toml", "--cluster", "nonsense://"], "Error"),
    ],
)
def test_bad_input_is_one_line(mgeo, arguments, message):
    done = mgeo(*arguments)
    assert done.exit_code == 2
    assert message in done.stderr
    assert len(done.stderr.splitlines()) == 1


SLOW = ONE.replace('"cantilever"', '"slow-cantilever"')


@pytest.mark.slow
def test_a_study_that_is_interrupted_goes_on(tmp_path, stand_in_environment, stand_in):
    (tmp_path / "slow.toml").write_text(SLOW)
    command = [sys.executable, "-m", "mgeo", "study", "slow.toml", "--jobs", "1"]
    # on a loaded machine the signal comes seconds late: what is left must take longer
    slowly = stand_in_environment | {"STAND_IN_SECONDS": "0.3"}
    settings = {"cwd": tmp_path, "env": slowly, "text": True}
    runs = tmp_path / "studies" / "slow" / "runs"

    def files():
        return {path: path.stat().st_mtime_ns for path in runs.glob("*.npz")}

    def started(stop_at):
        heard = partial(signal.signal, signal.SIGINT, signal.SIG_DFL)  # under nohup it is ignored
        process = subprocess.Popen(command, stderr=subprocess.PIPE, preexec_fn=heard, **settings)
        deadline = time.monotonic() + 300
        while len(files()) < stop_at:
            assert process.poll() is None
            assert time.monotonic() < deadline
            time.sleep(0.01)
        return process

    interrupted = started(2)
    interrupted.send_signal(signal.SIGINT)
    _, errors = interrupted.communicate(timeout=300)
    assert interrupted.returncode == 130
    assert "interrupted; the same command goes on with what is in studies/slow" in errors
    kept = files()
    killed = started(len(kept) + 1)
    os.kill(killed.pid, signal.SIGKILL)
    killed.communicate(timeout=300)
    kept |= files()
    assert len(kept) < 8
    settings["env"] = stand_in_environment
    done = subprocess.run(command, capture_output=True, check=True, **settings)
    assert f"8 runs, {len(kept)} of them found on disk" in done.stderr
    assert {path: when for path, when in files().items() if path in kept} == kept
    whole = run_study(parse_study(ONE, tmp_path), tmp_path / "whole", n_jobs=1, progress=False)
    written = (tmp_path / "studies" / "slow" / "table.csv").read_text()
    assert written == (tmp_path / "whole" / "table.csv").read_text()
    assert len(next(iter(whole.values())).table) == 24


@pytest.mark.campaign
@pytest.mark.slow
def test_sigterm_ends_a_study_and_its_processes(tmp_path, stand_in_environment, stand_in):
    (tmp_path / "slow.toml").write_text(SLOW)
    command = [sys.executable, "-m", "mgeo", "study", "slow.toml", "--jobs", "2"]
    slowly = stand_in_environment | {"STAND_IN_SECONDS": "0.3"}
    with subprocess.Popen(
        command, cwd=tmp_path, env=slowly, stderr=subprocess.PIPE, text=True, start_new_session=True
    ) as process:
        deadline = time.monotonic() + 300
        while not list(tmp_path.glob("studies/slow/runs/*.npz")):
            assert process.poll() is None
            assert time.monotonic() < deadline
            time.sleep(0.01)
        process.terminate()
        _, errors = process.communicate(timeout=30)  # idle workers would stay for minutes
    assert process.returncode == 143
    assert "interrupted; the same command goes on with what is in studies/slow" in errors
    deadline = time.monotonic() + 30
    while time.monotonic() < deadline:
        try:
            os.killpg(process.pid, 0)  # whether there is anybody in its group
        except ProcessLookupError:
            return
        time.sleep(0.05)
    os.killpg(process.pid, signal.SIGKILL)
    pytest.fail("some of its processes were left")


def test_a_folder_without_a_comparison_is_named(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"holds no comparison: there is no provenance"):
        read_comparison(tmp_path)
    (tmp_path / "provenance.json").write_text('{"problem": {"name": "pymoo:zdt1", "options": {}}}')
    with pytest.raises(ValueError, match=r"provenance.json: algorithms is missing"):
        read_comparison(tmp_path)


@pytest.mark.slow
def test_the_papers_table_at_a_small_size(tmp_path):
    pytest.importorskip("mgeo_attitude")
    study = read_study(STUDIES / "table3.toml").reduced(360, 1)
    (found,) = run_study(study, tmp_path / "out", n_jobs=2, progress=False).values()
    final = found.final()
    assert len(final) == 6
    both = final["points, first orbit"] + final["points, second orbit"]
    assert both.tolist() == final["points"].tolist()
    assert (found.space.origin, found.space.reference_point.tolist()) == ("problem", [1.0, 1.0])
    # what minimize gives, whose archive of MGEO_real holds the same points
    row = final[final["algorithm"] == "σ = 1.0"].iloc[0]
    result = minimize(found.problem, MGEOReal(sigma=1.0), ("n_eval", 360), seed=1)
    assert row["points"] == len(result.F)
    area = HV(ref_point=np.ones(2))(found.problem.indicator_space(result.F))
    assert row["hypervolume"] == pytest.approx(area, rel=1e-12)
    page = (tmp_path / "out" / "report.html").read_text()
    assert "Compared with" not in page  # their counts are those of another budget
