"""The report as text: complete, self-contained, and nothing in it that a file brought along."""

import json
import re
from html import unescape
from html.parser import HTMLParser
from importlib.resources import files

import numpy as np
import pandas as pd
import plotly.graph_objects as go
import pytest
from typer.testing import CliRunner

from mgeo.cli.app import app
from mgeo.report.build import hypervolume_history, report_html
from mgeo.report.solutions import planned_rows
from mgeo.runs.answer import RepresentativeSolution, answer
from mgeo.store.run_folder import read_run

EVIL = "</script><script>alert('x')</script><img src=x onerror=alert(1)>"


class Tags(HTMLParser):
    """Counts tags, collects what a browser would load, and reads the data of the page."""

    def __init__(self, html):
        super().__init__()
        self.count, self.loading, self.data, self._reading = {}, [], "", False
        self.feed(html)

    def handle_starttag(self, tag, attrs):
        self.count[tag] = self.count.get(tag, 0) + 1
        self.loading += [(tag, v) for name, v in attrs if name in ("src", "href", "srcset")]
        self.loading += [(tag, name) for name, _ in attrs if name.startswith("on")]
        self._reading = ("id", "data") in attrs

    def handle_data(self, text):
        if self._reading:
            self.data += text

    def handle_endtag(self, tag):
        self._reading = False


def mgeo(*arguments):
    return CliRunner().invoke(app, list(map(str, arguments)))


@pytest.mark.slow
def test_the_command_writes_into_the_folder_or_elsewhere(solved, tmp_path):
    folder = solved()
    done = mgeo("report", folder)
    assert done.exit_code == 0, done.output
    assert "written:" in done.stdout
    text = (folder / "report.html").read_text(encoding="utf-8")
    assert text == report_html(folder)  # the same run gives the same report
    other = tmp_path / "elsewhere.html"
    quiet = mgeo("report", folder, "--out", other, "-q")
    assert (quiet.exit_code, quiet.stdout, other.read_text(encoding="utf-8")) == (0, "", text)


def test_a_folder_without_a_run_is_one_line(tmp_path):
    done = mgeo("report", tmp_path)
    assert (done.exit_code, done.stdout) == (2, "")
    assert re.fullmatch(r"Error: .* holds no run: there is no run.json\n", done.stderr)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("out", "flags", "message"),
    [
        ("a.txt", [], "--out a.txt: expected a name that ends in .html"),
        ("none/a.html", ["--png"], "--out none/a.html: there is no folder none"),
        ("folder.html", [], "folder.html is a folder: expected a file, or none yet"),
        ("a.html", ["--pdf"], "figures is a file: expected a folder to write figures into"),
    ],
)
def test_what_cannot_be_written_is_refused_before_any_work(
    tmp_path, monkeypatch, out, flags, message
):
    monkeypatch.setattr("mgeo.report.build.report_html", lambda folder: pytest.fail("it was made"))
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder.html").mkdir()
    (tmp_path / "figures").touch()
    done = mgeo("report", tmp_path, "--out", out, *flags)
    assert (done.exit_code, done.stdout, done.stderr) == (2, "", f"Error: {message}\n")
    assert not (tmp_path / "none").exists()


def test_it_loads_nothing_and_has_all_solutions(solved):
    folder = solved()
    tags = Tags(report_html(folder))
    assert tags.loading == []
    assert tags.count["script"] == 3  # plotly.js, data, the page's own
    data = json.loads(tags.data)
    run = read_run(folder)
    np.testing.assert_array_equal(
        np.array(data["table"]["rows"]), np.hstack([run.outcome.X, run.outcome.F])
    )
    rows = np.concatenate([t.get("customdata", []) for t in data["front"]["data"]])
    assert sorted(rows) == list(range(len(run.outcome.X)))


def test_the_answer_and_the_front_come_first(solved):
    folder = solved()
    html = report_html(folder)
    titles = ["Knee and extremes", "Front and solutions", "All solutions", "What was run"]
    places = [html.index(f"<h2>{title}</h2>") for title in titles]
    assert places == sorted(places)
    outcome = read_run(folder).outcome
    from stand_in import Cantilever

    assert str(answer(Cantilever().view(outcome.X))) in html[: places[0]]
    data = json.loads(Tags(html).data)
    assert data["answers"]["0"] == Cantilever().view(outcome.X[:1]).answers()[0]
    assert data["limits"]["0"] == []  # bounds of the search are none
    assert 'name="viewport"' in html


def test_limits_are_told_in_their_units(solved, monkeypatch):
    from stand_in import CantileverView

    def limits(self):
        columns = {"unit": "kg", "value": 3.0, "bound": "at most", "limit": 2.0, "margin": -1.0}
        return [pd.DataFrame(columns, index=["mass"]) for _ in self.X]

    monkeypatch.setattr(CantileverView, "limits", limits, raising=False)
    data = json.loads(Tags(report_html(solved())).data)
    assert data["limits"]["0"] == [["mass", False, "3 kg, at most 2 kg: exceeded by 1 kg"]]


def test_hostile_strings_stay_text(solved, monkeypatch):
    folder = solved()
    from stand_in import Cantilever, CantileverView

    monkeypatch.setattr(Cantilever, "var_names", (f"d {EVIL}", "l"))
    monkeypatch.setattr(
        CantileverView, "describe", lambda self: pd.DataFrame({EVIL: [EVIL] * len(self.X)})
    )
    monkeypatch.setattr(
        CantileverView,
        "solution_figures",
        lambda self: [{EVIL: go.Figure(layout_title_text=EVIL)} for _ in self.X],
        raising=False,
    )
    monkeypatch.setattr(Cantilever, "from_options", classmethod(lambda cls, options: cls()))
    run_file, front = folder / "run.json", folder / "front.csv"
    told = json.loads(run_file.read_text())
    told["variables"][0] = told["objectives"][0] = f"d {EVIL}"
    told["objectives"][0] += "2"
    told["configuration"]["options"] = {EVIL: EVIL}
    told["configuration"]["algorithm"] = EVIL
    told["configuration"]["parameters"] = {EVIL: EVIL}
    told["failures"] = {EVIL: 3}
    told["versions"] = {EVIL: EVIL}
    run_file.write_text(json.dumps(told))
    lines = pd.read_csv(front)
    lines.columns = [*told["variables"], *told["objectives"]]
    lines.to_csv(front, index=False)
    table = {"columns": [EVIL, "b"], "rows": [[EVIL, 1.5]]}
    told = {"title": EVIL, "conclusion": EVIL, **table}
    told |= about(folder, options=Cantilever().options())
    (folder / "verification.json").write_text(json.dumps(told))
    (folder / "verification-of-another.json").write_text(json.dumps(told | {"problem": EVIL}))
    html = report_html(folder)
    assert "(verification.json, solution 0)" in html
    assert "verification-of-another.json is ignored" in html
    tags = Tags(html)
    assert tags.loading == []
    assert (tags.count["script"], tags.count.get("img", 0)) == (3, 0)
    assert html.count("alert(") > 10  # they are there, as text
    assert EVIL in json.loads(tags.data)["described"]["columns"]


def test_the_history_of_a_recorded_run_ends_with_its_hypervolume(solved):
    from mgeo import read_record
    from mgeo.plugins.problems import load_problem

    folder = solved("--record")
    run = read_run(folder)
    record = read_record(folder / "evaluations")
    evaluations, volumes = hypervolume_history(load_problem("cantilever"), run.outcome, record)
    assert (evaluations[0], evaluations[-1]) == (1, run.outcome.evaluations)
    assert (np.diff(volumes) >= -1e-12).all()
    assert volumes[-1] == pytest.approx(run.outcome.hypervolume, rel=1e-9)
    assert "saved no record" not in report_html(folder)
    assert "saved no record" in report_html(solved(name="other"))


def test_a_run_of_another_problem_is_refused(solved):
    folder = solved()
    told = json.loads((folder / "run.json").read_text())
    told["configuration"] |= {"problem": "zdt1", "options": {}}
    (folder / "run.json").write_text(json.dumps(told))
    done = mgeo("report", folder)
    assert done.exit_code == 2
    assert "the front has 2 variables and 2 objectives: expected 30 and 2" in done.stderr


def test_a_large_front_keeps_the_highlights_and_a_bounded_number_of_plans():
    rows = planned_rows(
        [RepresentativeSolution(7, "knee"), RepresentativeSolution(49_999, "best")], 50_000
    )
    assert len(rows) <= 300
    assert {0, 7, 49_999} <= set(rows.tolist())
    assert planned_rows([], 300).tolist() == list(range(300))


def about(folder, row=0, **changes):
    """What a verification of a solution of a run says that it is about."""
    run = read_run(folder)
    design = run.outcome.X[row].tolist()
    known = {
        "problem": run.configuration.problem,
        "options": dict(run.configuration.options),
        "design": design,
    }
    return known | changes


def test_simulated_flights_are_shown_where_there_are_some(solved):
    folder = solved()
    assert "no file <code>verification" in report_html(folder)
    table = {"columns": ["state", "ratio"], "rows": [["a", 1.25], ["b", 2]]}
    file = folder / "verification-knee.json"
    told = {"title": "9 flights", "conclusion": "achieved", **table, **about(folder, 3)}
    file.write_text(json.dumps(told))
    html = report_html(folder)
    assert "<h3>9 flights</h3>" in html
    assert "(verification-knee.json, solution 3)" in html
    assert "<tr><td>a</td><td>1.25</td></tr><tr><td>b</td><td>2</td></tr>" in html
    table["rows"][1] = ["b"]
    for text in (json.dumps(told | table), "{", "[]"):
        file.write_text(text)
        done = mgeo("report", folder)
        assert (done.exit_code, done.stderr.count("\n")) == (2, 1)
        assert "verification-knee.json" in done.stderr


@pytest.mark.cases(2)
@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"design": [0.02, 0.5]}, "its design is no solution of this front"),
        ({"design": "x"}, "its design is no solution of this front"),
        ({"problem": "zdt1"}, "it is about another problem, problem = 'zdt1', expected"),
        ({"options": {"load": 7.0}}, "about another problem, options.load = 7.0, expected 1000.0"),
        ({"options": None}, "it is about another problem, options = None, expected"),
    ],
)
def test_flights_of_another_front_are_not_shown(solved, changes, reason):
    folder = solved()
    told = {"title": "9 flights", "conclusion": "achieved", "columns": ["a"], "rows": [[1]]}
    (folder / "verification.json").write_text(json.dumps(told | about(folder, **changes)))
    html = report_html(folder)
    assert "9 flights" not in html
    (line,) = re.findall(r"<p class=note>(verification.json is ignored: .*?)</p>", html)
    assert reason in unescape(line)


def test_flights_that_do_not_say_of_what_are_not_shown(solved):
    folder = solved()
    told = {"title": "9 flights", "conclusion": "achieved", "columns": ["a"], "rows": [[1]]}
    known = {key: value for key, value in about(folder).items() if key != "options"}
    (folder / "verification.json").write_text(json.dumps(told | known))
    html = report_html(folder)
    assert "9 flights" not in html
    assert "is ignored: it does not say what it is about, its options</p>" in html


@pytest.mark.slow
def test_flights_of_the_front_before_are_not_shown(solved):
    """A longer run, or another one, has left the solution behind."""
    folder = solved()
    told = {"title": "9 flights", "conclusion": "achieved", "columns": ["a"], "rows": [[1]]}
    X = read_run(folder).outcome.X.tolist()
    files = {row: folder / f"verification-{row}.json" for row in range(len(X))}
    for row, file in files.items():
        file.write_text(json.dumps(told | about(folder, row)))
    assert report_html(folder).count("9 flights") == len(X)
    assert mgeo("resume", folder, "--evaluations", 4000, "-q").exit_code == 0
    later = read_run(folder).outcome.X.tolist()
    stayed = [row for row in files if X[row] in later]
    assert 0 < len(stayed) < len(X)
    html = report_html(folder)
    shown = re.findall(r"\(verification-(\d+).json, solution \d+\)", html)
    ignored = re.findall(r"verification-(\d+).json is ignored", html)
    assert sorted(map(int, shown)) == stayed
    assert len(ignored) == len(X) - len(stayed)
    solved("--overwrite", "--seed", "2")
    assert "9 flights" not in report_html(folder)


def test_a_large_front_has_every_solution_and_few_details(solved):
    import dataclasses

    from mgeo.store.run_folder import write_run

    folder = solved()
    run = read_run(folder)
    X = np.random.default_rng(2).uniform([0.01, 0.2], [0.05, 1.0], (3000, 2))
    F = np.column_stack([X[:, 0], 1.0 / X[:, 0]])
    order = np.argsort(F[:, 0])
    none = np.empty((3000, 0))
    found = {"X": X[order], "F": F[order], "G": none, "H": none}
    outcome = run.outcome.model_copy(update=found)
    write_run(folder, dataclasses.replace(run, outcome=outcome), overwrite=True)
    data = json.loads(Tags(report_html(folder)).data)
    assert len(data["table"]["rows"]) == 3000
    assert len(data["planned"]) <= 300
    assert set(data["described"]["rows"]) == set(map(str, data["planned"]))
    points = data["front"]["data"][-1]
    assert points["customdata"] == list(range(3000))
    assert "hovertext" not in points or points["hovertext"] is None


def test_colors_of_both_themes_can_be_read():
    css = files("mgeo.figures").joinpath("assets", "theme.css").read_text(encoding="utf-8")
    themes = [
        dict(re.findall(r"--(\w+): (#\w+)", part))
        for part in re.findall(r":root[^{]*\{.*?\}", css, re.S)
    ]
    assert len(themes) == 2
    for colors in themes:
        for text in ("ink", "soft", "accent", "bad"):
            for ground in ("paper", "panel"):
                assert contrast(colors[text], colors[ground]) >= 4.5, (text, ground)


def contrast(one, other):
    """Contrast ratio of WCAG 2.1 (section 1.4.3), from 1 to 21."""

    def luminance(color):
        digits = color[1:] if len(color) == 7 else "".join(2 * c for c in color[1:])
        parts = np.array([int(digits[i : i + 2], 16) for i in (0, 2, 4)]) / 255.0
        linear = np.where(parts <= 0.03928, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)
        return linear @ [0.2126, 0.7152, 0.0722]

    bright, faint = sorted([luminance(one), luminance(other)], reverse=True)
    return (bright + 0.05) / (faint + 0.05)
