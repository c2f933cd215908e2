"""Two runs, or solutions' files, side by side; and a review of one: text, without a browser."""

import json
import re
from html import unescape

import pandas as pd
import pytest
from typer.testing import CliRunner

from mgeo.cli.app import app
from mgeo.plugins.review import Review, Section
from mgeo.report import compare_html, report_html
from mgeo.store.run_folder import read_run

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
