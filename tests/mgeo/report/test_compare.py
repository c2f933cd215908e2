"""Two runs, or solutions' files, side by side; and a review of one: text, without a browser."""

import json
import os
import re
from dataclasses import replace
from html import unescape

import pandas as pd
import pytest
from typer.testing import CliRunner

from mgeo.cli.app import app
from mgeo.plugins.problems import load_problem
from mgeo.plugins.shown import Review, Section
from mgeo.report.build import report_html
from mgeo.report.compare import compare_html, distinct, fronts_figure, read
from mgeo.store.run_folder import read_run
from mgeo.store.solution_file import solution_document

from .test_report import EVIL, Tags


def mgeo(*arguments):
    return CliRunner().invoke(app, list(map(str, arguments)))


def rows(html):
    """Cells of all rows of tables."""
    found = re.findall(r"<tr>(.*?)</tr>", html, re.S)
    return [re.findall(r"<t[dh][^>]*>(.*?)</t[dh]>", row) for row in found]


@pytest.fixture
def two(solved):
    return solved(), solved("--seed", "2", name="other")


def test_two_runs_are_told_side_by_side(two, tmp_path):
    html = compare_html(*two)
    assert "<h1>run beside other</h1>" in html
    assert ["seed", "1", "2"] in rows(html)
    assert "Their options are the same." in html
    fronts = [read_run(folder).outcome.F for folder in two]
    assert ["solutions", *(str(len(F)) for F in fronts)] in rows(html)
    (mass,) = (row for row in rows(html) if row[0] == "mass [kg]" and len(row) == 4)
    assert float(mass[3]) == pytest.approx(float(mass[2]) / float(mass[1]), rel=1e-2)
    assert html.count("<h3>Solution</h3>") == 2
    assert Tags(html).loading == []
    out = tmp_path / "both.html"
    done = mgeo("report", *two, "--out", out, "--json")
    assert json.loads(done.stdout)["file"] == str(out)
    assert out.read_text(encoding="utf-8") == html


def test_what_cannot_be_compared_is_one_line(two, tmp_path):
    other = tmp_path / "some.json"
    other.write_text("{}")
    for arguments, message in {
        (two[0], other): "some.json: expected a run folder, or a solution's file",
        (two[0], tmp_path / "none"): "there is neither a run folder nor a file",
        (*two, two[0]): "3 runs: expected one, or two",
        (*two, "--png"): "of two runs there is a page only",
        (two[0], "--solution", "999"): "solution 999: expected 0 to",
    }.items():
        done = mgeo("report", *arguments)
        assert (done.exit_code, done.stdout) == (2, "")
        assert message in done.stderr
        assert done.stderr.count("\n") == 1


@pytest.fixture
def reviewed(monkeypatch):
    """The stand-in tells more of one solution, in words that are no markup."""
    from stand_in import CantileverView

    def review(self):
        assert len(self.X) == 1
        table = pd.DataFrame({"kept": [True, False], EVIL: [1.5, 2.0]}, index=[EVIL, "b"])
        return Review(EVIL, "worth it", (Section(EVIL, (EVIL,), table, EVIL),))

    monkeypatch.setattr(CantileverView, "review", review, raising=False)


def test_a_review_is_text_with_a_place_for_signatures(solved, reviewed):
    folder = solved()
    html = report_html(folder, solution=2)
    assert "<h2>Solution 2, for review</h2>" in html
    assert json.loads(Tags(html).data)["first"] == 2
    shown = html.partition("<h2>Solution 2, for review</h2>")[2].partition("</section>")[0]
    assert EVIL not in html
    assert unescape(shown).count(EVIL) == 5  # title, line, column, row and note
    assert '<td class="text exceeded">NO</td>' in shown
    assert ">1.5</td>" in shown
    assert [row[0] for row in rows(html)[-3:]] == ["prepared", "checked", "approved"]
    assert unescape(html.partition("<h1>")[2].partition("</h1>")[0]) == EVIL


def test_without_one_there_is_nothing_to_sign(solved):
    assert "Approval" not in report_html(solved())


def test_a_verification_tells_all_its_tables(solved):
    folder = solved()
    run = read_run(folder)
    found = {
        "title": "flights",
        "conclusion": "achieved",
        "columns": ["state"],
        "rows": [["x"]],
        "path_limits": [{"limit": "<b>", "broken [%]": 12.5}],
        "problem": run.configuration.problem,
        "options": run.configuration.options,
        "design": run.outcome.X[1].tolist(),
    }
    (folder / "verification-2.json").write_text(json.dumps(found), encoding="utf-8")
    html = report_html(folder)
    assert "<h4>path limits</h4>" in html
    assert ["&lt;b&gt;", "12.5"] in rows(html)


@pytest.fixture
def files(two, tmp_path):
    """Two solutions' files of the same name, in folders of their own."""
    written = []
    for i, folder in enumerate(two):
        problem = load_problem("cantilever", {"load": 1000.0 + 500.0 * i})
        place = tmp_path / f"plans{i}"
        place.mkdir()
        document = solution_document(problem, "cantilever", read_run(folder).outcome.X[1 + i])
        (place / "plan.json").write_text(json.dumps(document))
        written.append(place / "plan.json")
    return written


def test_two_files_are_told_apart(files):
    html = compare_html(*files)
    names = ["plans0/plan.json", "plans1/plan.json"]
    assert f"<h1>{names[0]} beside {names[1]}</h1>" in html
    assert ["option", *names] in rows(html)
    assert ["load", "1000.0", "1500.0"] in rows(html)
    assert "<h2>Fronts</h2>" not in html
    assert Tags(html).loading == []


@pytest.mark.cases(2)
@pytest.mark.parametrize("first", [True, False])
def test_a_solution_beside_a_run_is_in_its_front(two, files, first):
    both = [two[0], files[1]] if first else [files[1], two[0]]
    html = compare_html(*both)
    assert html.count("<h2>Fronts</h2>") == 1
    X = json.loads(files[1].read_text())["design"]
    view = load_problem("cantilever", {"load": 1500.0}).view([X])
    assert unescape(view.answers()[0]) in unescape(html)
    (mass,) = (row for row in rows(html) if row[0] == "mass [kg]" and len(row) == 4)
    assert float(mass[2 if first else 1]) == pytest.approx(view.F[0, 0], rel=1e-4)
    found = fronts_figure([read(path) for path in both])
    points = [trace for trace in found.data if len(trace.x) == 1]
    assert [trace.showlegend for trace in points] == ([False, True] if first else [True, False])
    assert points[1 if first else 0].x[0] == view.F[0, 0]


def test_what_is_the_same_is_told_once(two, reviewed, monkeypatch):
    from stand_in import CantileverView

    html = compare_html(*two)  # the same review of any
    assert html.count("<p class=note>both</p>") == 1
    assert unescape(html).count(f"<h3>{EVIL}</h3>") == 1
    own = CantileverView.review

    def review(self):
        found = own(self)
        (section,) = found.sections
        return replace(found, sections=(replace(section, lines=(str(self.F),)),))

    monkeypatch.setattr(CantileverView, "review", review)
    assert "<p class=note>both</p>" not in compare_html(*two)


def test_paths_are_told_apart_by_their_ends(tmp_path):
    for one, other, names in [
        ("a/x/run", "b/x/run", [f"{os.sep}".join([k, "x", "run"]) for k in "ab"]),
        ("a/x", "a/y", ["x", "y"]),
        ("a/x", "a/x", ["x, once", "x, again"]),
    ]:
        assert distinct(tmp_path / one, tmp_path / other) == names


def test_a_file_alone_and_one_that_is_no_json_are_told_of(files, two):
    for arguments, message in {
        (files[0],): "plan.json is a file: expected the folder of a run, or two",
        (two[0] / "front.csv", files[0]): "front.csv: ",
    }.items():
        done = mgeo("report", *arguments)
        assert done.exit_code == 2
        assert message in done.stderr
        assert done.stderr.count("front.csv") <= 1
