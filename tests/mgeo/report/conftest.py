"""Run folders of the stand-in problem, and a parser of HTML pages."""

import json
import shutil
from html.parser import HTMLParser

import pytest
from typer.testing import CliRunner

from mgeo.cli.app import app

SMALL = ["--algorithm", "mgeo-real", "--walkers", "4", "--set", "sigma=0.05"]


@pytest.fixture(scope="session")
def run_cache(tmp_path_factory):
    """Dict of run folders by problem and options, and the parent folder of these folders."""
    return {}, tmp_path_factory.mktemp("runs")


@pytest.fixture
def solved(run_cache, stand_in, tmp_path):
    """Return a function that solves a problem with a small budget, and returns a new run folder.

    Runs with equal options are computed once and copied.
    """
    runs, parent = run_cache

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
    """HTML page, parsed into its tags, the resources that it loads, and its data.

    Attributes
    ----------
    tags : list of str
        Name of each start tag.
    loading : list of tuples
        Attributes that load a resource or run a script, as (tag, value or attribute name).
    data : Any
        JSON value in the element with the ID ``data``, None if there is no such element.
    """

    def __init__(self, html):
        super().__init__()
        self.tags, self.loading, self._text, self._reading = [], [], "", False
        self.feed(html)
        self.data = json.loads(self._text or "null")

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        links = [v for name, v in attrs if name in ("src", "href", "srcset")]
        self.loading += [(tag, v) for v in links if not v.startswith("#")]
        self.loading += [(tag, name) for name, _ in attrs if name.startswith("on")]
        self._reading = ("id", "data") in attrs

    def handle_data(self, text):
        if self._reading:
            self._text += text

    def handle_endtag(self, tag):
        self._reading = False
