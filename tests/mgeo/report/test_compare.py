"""Two runs, or two solutions in files, side by side."""

import json
import re

import pytest

from mgeo.plugins.problems import load_problem
from mgeo.report.compare import build_comparison_html, draw_fronts, read_compared_solution
from mgeo.store.run_folder import read_run
from mgeo.store.solution_file import build_solution_document

from .conftest import Page, mgeo


def rows(html):
    """Return the cells of all rows of tables."""
    found = re.findall(r"<tr>(.*?)</tr>", html, re.S)
    return [re.findall(r"<t[dh][^>]*>(.*?)</t[dh]>", row) for row in found]


@pytest.fixture
def two(solved):
    return solved(), solved("--seed", "2", name="other")


@pytest.fixture
def files(two, tmp_path):
    """Two solutions' files of the same name, in folders of their own."""
    written = []
    for i, folder in enumerate(two):
        problem = load_problem("cantilever", {"load": 1000.0 + 500.0 * i})
        path = tmp_path / f"plans{i}" / "plan.json"
        path.parent.mkdir()
        document = build_solution_document(problem, "cantilever", read_run(folder).outcome.X[1 + i])
        path.write_text(json.dumps(document))
        written.append(path)
    return written


def test_two_runs_side_by_side(two, tmp_path):
    html = build_comparison_html(*two)
    assert ["seed", "1", "2"] in rows(html)
    fronts = [read_run(folder).outcome.F for folder in two]
    assert ["solutions", *(str(len(F)) for F in fronts)] in rows(html)
    (mass,) = (row for row in rows(html) if row[0] == "mass [kg]" and len(row) == 4)
    assert float(mass[3]) == pytest.approx(float(mass[2]) / float(mass[1]), rel=1e-2)
    assert html.count("<h3>Solution</h3>") == 2
    assert Page(html).loading == []
    out = tmp_path / "both.html"
    done = mgeo("report", *two, "--out", out, "--json")
    assert json.loads(done.stdout)["file"] == str(out)
    assert out.read_text(encoding="utf-8") == html


def test_two_files_of_one_name_are_distinguished(files):
    html = build_comparison_html(*files)
    assert ["option", *map(str, files)] in rows(html)
    assert ["load", "1000.0", "1500.0"] in rows(html)
    assert "<h2>Fronts</h2>" not in html


def test_a_solution_beside_a_run_is_drawn_with_its_front(two, files):
    html = build_comparison_html(two[0], files[1])
    assert html.count("<h2>Fronts</h2>") == 1
    x = json.loads(files[1].read_text())["design"]
    view = load_problem("cantilever", {"load": 1500.0}).view([x])
    assert view.summaries()[0] in html
    points = draw_fronts([read_compared_solution(two[0]), read_compared_solution(files[1])]).data[
        -1
    ]
    assert [points.x[0], points.y[0]] == view.F[0].tolist()


def test_bad_input_is_one_line(two, tmp_path):
    other = tmp_path / "some.json"
    other.write_text("{}")
    for arguments, message in {
        (two[0], other): "some.json",
        (two[0], two[0] / "front.csv"): "front.csv",
        (two[0], tmp_path / "none"): "there is neither a run folder nor a file",
        (two[0], two[0]): "twice",
        (*two, two[0]): "3 runs",
        (*two, "--png"): "expected no options for figures",
        (other,): "some.json is a file",
    }.items():
        done = mgeo("report", *arguments)
        assert (done.exit_code, done.stdout, done.stderr.count("\n")) == (2, "", 1)
        assert message in done.stderr
