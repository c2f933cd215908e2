"""HTML report of a run: its data, and the safety of texts from files and plugins."""

import dataclasses
import json

import numpy as np
import pandas as pd
import plotly.graph_objects as go
import pytest

from mgeo import read_record
from mgeo.explore import Explorer
from mgeo.plugins.problems import load_problem
from mgeo.plugins.review import Review, Section
from mgeo.report.build import build_report_html
from mgeo.report.history import compute_hypervolume_history
from mgeo.runs.summary import select_default_solution
from mgeo.store.run_folder import read_run, write_run

from .conftest import Page, mgeo

EVIL = "</script><script>alert('x')</script><img src=x onerror=alert(1)>\u2028{{1}}%{x}"


@pytest.mark.slow
def test_command_writes_into_the_folder_or_another_file(solved, tmp_path):
    folder = solved()
    assert mgeo("report", folder).exit_code == 0
    text = (folder / "report.html").read_text(encoding="utf-8")
    assert text == build_report_html(folder)  # Equal runs give equal reports.
    other = tmp_path / "elsewhere.html"
    quiet = mgeo("report", folder, "--out", other, "-q")
    assert (quiet.exit_code, quiet.stdout, other.read_text(encoding="utf-8")) == (0, "", text)


@pytest.mark.parametrize(
    ("out", "message"),
    [
        ("a.html", "run.json"),
        ("a.txt", "--out a.txt"),
        ("none/a.html", "there is no folder none"),
        ("folder.html", "folder.html is a folder"),
    ],
)
def test_invalid_input_is_one_line_and_writes_nothing(tmp_path, monkeypatch, out, message):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder.html").mkdir()
    done = mgeo("report", tmp_path, "--out", out)
    assert (done.exit_code, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert message in done.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["folder.html"]


def test_report_loads_no_resources_and_has_all_solutions(solved):
    folder = solved()
    html = build_report_html(folder)
    page = Page(html)
    assert page.loading == []
    assert page.tags.count("script") == 3  # plotly.js, the data, and the script of the page
    outcome = read_run(folder).outcome
    np.testing.assert_array_equal(page.data["table"]["rows"], np.hstack([outcome.X, outcome.F]))
    rows = np.concatenate([t.get("customdata", []) for t in page.data["front"]["data"]])
    assert sorted(rows) == list(range(len(outcome.X)))
    view = load_problem("cantilever").view(outcome.X)
    default = select_default_solution(view.problem, outcome.F)
    assert f"number {default.row}, {default.label}" in html
    assert view.summaries()[default.row] in html
    assert page.data["summaries"]["0"] == view.summaries()[0]


def build_verification(folder, row=0, **changes):
    """Return the content of a verification file for a solution of a run."""
    run = read_run(folder)
    return {
        "title": "9 runs",
        "conclusion": "achieved",
        "columns": ["state", "ratio"],
        "rows": [["a", 1.25], ["b", 2]],
        "problem": run.configuration.problem,
        "options": dict(run.configuration.options),
        "design": run.outcome.X[row].tolist(),
        **changes,
    }


@pytest.fixture
def hostile_run(solved, monkeypatch):
    """Run folder in which every text of files and of the problem contains markup and scripts."""
    from stand_in import Cantilever, CantileverView

    folder = solved("--record")
    table = pd.DataFrame({EVIL: [1.5]}, index=[EVIL])
    review = Review(EVIL, EVIL, (Section(EVIL, (EVIL,), table, EVIL),))
    figure = go.Figure(layout_title_text=EVIL)
    monkeypatch.setattr(Cantilever, "var_names", (f"d {EVIL}", "l"))
    monkeypatch.setattr(Cantilever, "from_options", classmethod(lambda cls, options: cls()))
    for name, value in {
        "describe": lambda self: pd.DataFrame({EVIL: [EVIL] * len(self.X)}),
        "solution_figures": lambda self: [{EVIL: figure} for _ in self.X],
        "summaries": lambda self: [EVIL] * len(self.X),
        "warnings": lambda self: [EVIL],
        "review": lambda self: review,
    }.items():
        monkeypatch.setattr(CantileverView, name, value)
    document = json.loads((folder / "run.json").read_text())
    document["configuration"] |= {"algorithm": EVIL, "parameters": {EVIL: EVIL}}
    document["configuration"]["options"] = {EVIL: EVIL}
    document |= {"failures": {EVIL: 3}, "versions": {EVIL: EVIL}}
    (folder / "run.json").write_text(json.dumps(document))
    content = build_verification(
        folder, options=Cantilever().to_options(), title=EVIL, conclusion=EVIL
    )
    content |= {"columns": [EVIL, "b"], "rows": [[EVIL, 1.5]], EVIL: [{EVIL: EVIL}]}
    (folder / "verification.json").write_text(json.dumps(content))
    return folder


def test_texts_of_files_and_plugins_are_escaped(hostile_run):
    html = build_report_html(hostile_run)
    page = Page(html)
    assert page.loading == []
    assert (page.tags.count("script"), page.tags.count("img")) == (3, 0)
    assert html.count("alert(") > 10  # as text
    assert EVIL in page.data["descriptions"]["columns"]
    assert (
        html.split('id="data">')[1].split("</script>")[0].isascii()
    )  # U+2028 would end a line of JavaScript.


def test_history_ends_with_the_hypervolume_of_the_run(solved):
    folder = solved("--record")
    outcome = read_run(folder).outcome
    record = read_record(folder / "evaluations")
    evaluations, volumes = compute_hypervolume_history(load_problem("cantilever"), outcome, record)
    assert (evaluations[0], evaluations[-1]) == (1, outcome.n_evaluations)
    assert (np.diff(volumes) >= -1e-12).all()
    assert volumes[-1] == pytest.approx(outcome.hypervolume, rel=1e-9)
    assert Page(build_report_html(folder)).data["history"] is not None
    assert Page(build_report_html(solved(name="other"))).data["history"] is None


def test_run_of_another_problem_is_refused(solved):
    folder = solved()
    document = json.loads((folder / "run.json").read_text())
    document["configuration"] |= {"problem": "zdt1", "options": {}}
    (folder / "run.json").write_text(json.dumps(document))
    done = mgeo("report", folder)
    assert done.exit_code == 2
    assert "the front has 2 variables and 2 objectives: expected 30 and 2" in done.stderr


def test_verification_is_shown_with_all_tables(solved):
    folder = solved()
    file = folder / "verification-knee.json"
    bounded = {"constraint": "<b>", "bound_type": "at most", "bound_value": 1450.0}
    free = {"constraint": "c", "bound_type": "", "bound_value": None}
    shares = {"steered_runs_percent": 12.5, "in_90_percent_of_runs": 3.0}
    tables = {"path_constraints": [bounded | shares, free | shares]}
    file.write_text(json.dumps(build_verification(folder, 3, **tables)))
    html = build_report_html(folder)
    assert "(verification-knee.json, solution 3)" in html
    assert "<tr><td>a</td><td>1.25</td></tr><tr><td>b</td><td>2</td></tr>" in html
    assert "<h4>Path constraints</h4>" in html
    assert "&lt;b&gt;" in html
    table = html.partition("<h4>Path constraints</h4>")[2].partition("</table>")[0]
    assert "at most 1450<" in table
    assert "steered runs [%]" in table
    assert "90 % of runs" in table
    assert not any(key in table for key in ("_percent", "bound_type", "bound type"))
    for text in (json.dumps(build_verification(folder, rows=[["b"]])), "{"):
        file.write_text(text)
        done = mgeo("report", folder)
        assert (done.exit_code, done.stderr.count("\n")) == (2, 1)
        assert file.name in done.stderr


@pytest.mark.parametrize("changes", [{"design": [0.02, 0.5]}, {"options": {"load": 7.0}}])
def test_verification_of_another_solution_is_ignored(solved, changes):
    folder = solved()
    (folder / "verification.json").write_text(json.dumps(build_verification(folder, **changes)))
    html = build_report_html(folder)
    assert "9 runs" not in html
    assert "verification.json is ignored" in html


def test_large_front_has_all_solutions_and_few_figures(solved):
    folder = solved()
    run = read_run(folder)
    X = np.random.default_rng(2).uniform([0.01, 0.2], [0.05, 1.0], (3000, 2))
    F = np.column_stack([X[:, 0], 1.0 / X[:, 0]])
    order = np.argsort(F[:, 0])
    empty = np.empty((3000, 0))
    update = {"X": X[order], "F": F[order], "G": empty, "H": empty}
    outcome = run.outcome.model_copy(update=update)
    write_run(folder, dataclasses.replace(run, outcome=outcome), overwrite=True)
    data = Page(build_report_html(folder)).data
    assert len(data["table"]["rows"]) == 3000
    assert {0, 2999} < set(data["figure_rows"])
    assert len(data["figure_rows"]) <= 300
    assert set(data["descriptions"]["rows"]) == set(map(str, data["figure_rows"]))
    points = data["front"]["data"][-1]
    assert points["customdata"] == list(range(3000))
    assert "hovertext" not in points


def test_review_has_a_table_for_signatures(solved, monkeypatch):
    from stand_in import CantileverView

    folder = solved()
    assert "Approval" not in build_report_html(folder)
    table = pd.DataFrame({"satisfied": [True, False]}, index=["a", "b"])
    review = Review("Beam", "worth it", (Section("Margins", ("a line",), table),))
    monkeypatch.setattr(CantileverView, "review", lambda self: review, raising=False)
    html = build_report_html(folder, solution=2)
    assert Page(html).data["first"] == 2
    assert "<h1>Beam</h1>" in html
    assert '<td class="text exceeded">NO</td>' in html
    assert "Approval" in html
    assert "solution 999: expected 0 to" in mgeo("report", folder, "--solution", 999).stderr


def test_report_without_feasible_solution_shows_the_nearest(stand_in, monkeypatch, tmp_path):
    def infeasible(self, x, out, *args, **kwargs):
        out["F"] = np.column_stack([x[:, 0], 1.0 / (1.0 + x[:, 0])])
        out["G"] = np.column_stack([x[:, 0] + 1.0, x[:, 1] - 9.0])

    monkeypatch.setattr("pymoo.problems.multi.BNH._evaluate", infeasible)
    arguments = ["--algorithm", "mgeo-real", "--evaluations", 60, "--out", tmp_path / "run", "-q"]
    assert mgeo("solve", "bnh", *arguments).exit_code == 3
    html = build_report_html(tmp_path / "run")
    nearest = read_run(tmp_path / "run").outcome.nearest
    assert Page(html).data["table"]["rows"] == np.hstack([nearest.X, nearest.F]).tolist()
    assert "Nearest solutions" in html
    explorer = Explorer(tmp_path / "run")
    _, (first, _) = explorer.evaluate(explorer.X[explorer.default_position])
    assert first.margin == pytest.approx(-1.0 - explorer.X[explorer.default_position, 0])
