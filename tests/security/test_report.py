"""A run folder in which every text is hostile: the report shows it and runs nothing of it."""

import json
from html.parser import HTMLParser

import numpy as np
import pandas as pd
import pytest

from mgeo.report import report_html

from ..mgeo.conftest import stand_in  # noqa: F401 (fixtures)
from ..mgeo.report.conftest import browser, solved  # noqa: F401

HOSTILE = [
    "<script>document.title='owned'</script>",
    "</script><script>document.title='owned'</script>",
    "<img src=x onerror=\"document.title='owned'\">",
    "'\"><svg onload=\"document.title='owned'\">",
    "<a href=\"javascript:document.title='owned'\">here</a>",
    "\u2028document.title='owned'\u2029//",
    "<!--<script>",
    "]]>{{constructor.constructor('document.title=1')()}}",
    "%{customdata}<b onclick='document.title=1'>",
]


class Handlers(HTMLParser):
    """Collects attributes that could run something."""

    def __init__(self):
        super().__init__()
        self.seen = []

    def handle_starttag(self, tag, attributes):
        for name, value in attributes:
            if name.startswith("on") or (value or "").strip().lower().startswith("javascript:"):
                self.seen.append((tag, name, value))


@pytest.fixture
def hostile(solved, monkeypatch):  # noqa: F811
    """A run whose files have such texts wherever there is a text."""
    from stand_in import CantileverView

    every = " ".join(HOSTILE)
    folder = solved("--record")
    path = folder / "run.json"
    data = json.loads(path.read_text())
    names = {
        "variables": [f"{HOSTILE[0]} x", f"{HOSTILE[1]} y"],
        "objectives": [f"{HOSTILE[2]} a", f"{HOSTILE[3]} b"],
    }
    data |= names
    data["versions"] = {each: each for each in HOSTILE}
    data["failures"] = dict.fromkeys(HOSTILE, 1)
    data["configuration"]["algorithm"] = every
    data["configuration"]["parameters"] = {each: each for each in HOSTILE}
    path.write_text(json.dumps(data))
    table = pd.read_csv(folder / "front.csv")
    table.columns = [*names["variables"], *names["objectives"]]
    table.to_csv(folder / "front.csv", index=False)
    for path in (folder / "evaluations").iterdir():
        with np.load(path) as record:
            columns = ["generation", *table.columns, *record["columns"][5:]]
            np.savez(path, columns=columns, rows=record["rows"])
    tie = {
        "problem": data["configuration"]["problem"],
        "options": data["configuration"]["options"],
        "design": table.iloc[0, :2].tolist(),
    }
    result = {"title": every, "conclusion": every, "columns": HOSTILE, "rows": [HOSTILE], **tie}
    (folder / "verification.json").write_text(json.dumps(result))
    result["problem"] = every
    (folder / "verification-of-another.json").write_text(json.dumps(result))
    monkeypatch.setattr(
        CantileverView,
        "describe",
        lambda self: pd.DataFrame([HOSTILE] * len(self.X), columns=HOSTILE),
    )
    return folder


def test_no_text_of_a_file_becomes_markup(hostile):
    html = report_html(hostile)
    assert "(verification.json, solution 0)" in html
    assert "verification-of-another.json is ignored" in html
    ours = html.split("<body>")[1]
    for text in ("<img src", "<svg onload", "<a href", "<script>document"):
        assert text not in ours, text
    program = ours.split('id="data">')[1].split("</script>")[0]
    assert program.isascii()  # U+2028 ends a line of a program
    assert ours.count("<script") == 2  # the data, as no program, and the page's own program
    assert ours.count("</script>") == 2


@pytest.mark.slow
def test_a_browser_runs_nothing_of_it(hostile, browser):  # noqa: F811
    dom, messages = browser(report_html(hostile))
    assert messages == []
    assert "<title>owned" not in dom
    assert "<title>1</title>" not in dom
    assert 'data-shown="' in dom
    body = dom.split("<body")[1]
    found = Handlers()
    found.feed(dom)
    assert found.seen == []
    assert "&lt;script&gt;" in body
