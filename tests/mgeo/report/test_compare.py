"""Comparison of two runs or solution files."""

import json
import re

import pytest

from mgeo.plugins.problems import load_problem
from mgeo.report.compare import build_comparison_html, draw_fronts, read_compared_solution
from mgeo.store.run_folder import read_run
from mgeo.store.solution_file import build_solution_document

from .conftest import Page, mgeo


def list_rows(html):
    """Return the cell texts of each table row of a page."""
    rows = re.findall(r"<tr>(.*?)</tr>", html, re.S)
    return [re.findall(r"<t[dh][^>]*>(.*?)</t[dh]>", row) for row in rows]


@pytest.fixture
def folders(solved):
    return solved(), solved("--seed", "2", name="other")


@pytest.fixture
def files(folders, tmp_path):
    """Paths of two solution files of the same name in different folders."""
    paths = []
    for i, folder in enumerate(folders):
        problem = load_problem("cantilever", {"load": 1000.0 + 500.0 * i})
        path = tmp_path / f"plans{i}" / "plan.json"
        path.parent.mkdir()
        document = build_solution_document(problem, "cantilever", read_run(folder).outcome.X[1 + i])
        path.write_text(json.dumps(document))
        paths.append(path)
    return paths


def test_comparison_of_runs_has_both_fronts_and_metrics(folders, tmp_path):
    html = build_comparison_html(*folders)
    assert ["seed", "1", "2"] in list_rows(html)
    fronts = [read_run(folder).outcome.F for folder in folders]
    assert ["solutions on the front", *(str(len(F)) for F in fronts)] in list_rows(html)
    (mass,) = (row for row in list_rows(html) if row[0] == "mass [kg]" and len(row) == 4)
    assert float(mass[3]) == pytest.approx(float(mass[2]) / float(mass[1]), rel=1e-2)
    assert "<h3>Solution: run</h3>" in html
    assert "<h3>Solution: other</h3>" in html
    assert Page(html).loading == []
    out = tmp_path / "both.html"
    done = mgeo("report", *folders, "--out", out, "--json")
    assert json.loads(done.stdout)["file"] == str(out)
    assert out.read_text(encoding="utf-8") == html


def test_files_of_equal_names_are_labeled_by_their_paths(files):
    html = build_comparison_html(*files)
    assert ["option", *map(str, files)] in list_rows(html)
    assert ["load", "1000.0", "1500.0"] in list_rows(html)
    assert "<h2>Fronts</h2>" not in html


def test_comparison_of_run_and_file_draws_both(folders, files):
    html = build_comparison_html(folders[0], files[1])
    assert html.count("<h2>Fronts</h2>") == 1
    x = json.loads(files[1].read_text())["design"]
    view = load_problem("cantilever", {"load": 1500.0}).view([x])
    assert view.summaries()[0] in html
    points = draw_fronts(
        [read_compared_solution(folders[0]), read_compared_solution(files[1])]
    ).data[-1]
    assert [points.x[0], points.y[0]] == view.F[0].tolist()


def test_invalid_input_is_one_line(folders, tmp_path):
    other = tmp_path / "some.json"
    other.write_text("{}")
    for arguments, message in {
        (folders[0], other): "some.json",
        (folders[0], folders[0] / "front.csv"): "front.csv",
        (folders[0], tmp_path / "none"): "there is neither a run folder nor a file",
        (folders[0], folders[0]): "twice",
        (*folders, folders[0]): "3 runs",
        (*folders, "--png"): "expected no options for figures",
        (other,): "some.json is a file",
    }.items():
        done = mgeo("report", *arguments)
        assert (done.exit_code, done.stdout, done.stderr.count("\n")) == (2, "", 1)
        assert message in done.stderr
