"""Run folders of the stand-in problem, and the content of a page."""

import json
from html.parser import HTMLParser

import pytest
from typer.testing import CliRunner

from mgeo.cli.app import app


@pytest.fixture
def solved(stand_in, tmp_path):
    """Return a function that makes a small run and returns its folder."""

    def solve(*more, name="run", problem="cantilever"):
        folder = tmp_path / name
        arguments = [
            "solve",
            problem,
            "--algorithm",
            "mgeo-real",
            "--walkers",
            "4",
            "--set",
            "sigma=0.05",
        ]
        arguments += ["--evaluations", "400"]
        done = CliRunner().invoke(app, [*arguments, "--out", str(folder), "-q", *more])
        assert done.exit_code == 0, done.output
        return folder

    return solve


def mgeo(*arguments):
    return CliRunner().invoke(app, list(map(str, arguments)))


class Page(HTMLParser):
    """Tags of a page, what a browser would load for them, and the data of a report.

    Attributes
    ----------
    tags, loading : list
    data : Any
        JSON of the element ``data``.
    """

    def __init__(self, html):
        super().__init__()
        self.tags, self.loading, self._text, self._reading = [], [], "", False
        self.feed(html)
        self.data = json.loads(self._text or "null")

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.loading += [(tag, v) for name, v in attrs if name in ("src", "href", "srcset")]
        self.loading += [(tag, name) for name, _ in attrs if name.startswith("on")]
        self._reading = ("id", "data") in attrs

    def handle_data(self, text):
        if self._reading:
            self._text += text

    def handle_endtag(self, tag):
        self._reading = False
