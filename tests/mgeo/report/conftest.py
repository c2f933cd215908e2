"""Run folders of the stand-in problem, and the content of a page."""

import json
import shutil
from html.parser import HTMLParser

import pytest
from typer.testing import CliRunner

from mgeo.cli.app import app

SMALL = ["--algorithm", "mgeo-real", "--walkers", "4", "--set", "sigma=0.05"]


@pytest.fixture(scope="session")
def made(tmp_path_factory):
    """Folders of runs by problem and further options, and a folder for more of them."""
    return {}, tmp_path_factory.mktemp("made")


@pytest.fixture
def solved(made, stand_in, tmp_path):
    """Return a function that makes a small run, once, and returns a copy of its folder."""
    runs, parent = made

    def solve(*more, name="run", problem="cantilever"):
        key = (problem, *more)
        if key not in runs:
            runs[key] = parent / str(len(runs))
            arguments = [*SMALL, "--evaluations", 400, "--out", runs[key], "-q"]
            done = mgeo("solve", problem, *arguments, *more)
            assert done.exit_code == 0, done.output
        return shutil.copytree(runs[key], tmp_path / name)

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
