"""Run folders of the stand-in problem, and a browser."""

import re
import subprocess

import pytest
from typer.testing import CliRunner

from mgeo.cli.app import app
from mgeo.report import report_html

from ...browser import find_browser


@pytest.fixture
def solved(stand_in, tmp_path):
    """Makes a small run and gives its folder."""

    def solve(*more, name="run", problem="cantilever"):
        folder = tmp_path / name
        arguments = ["solve", problem, "--algorithm", "mgeo-real", "--runs", "4", "--sigma", "0.05"]
        arguments += ["--evaluations", "400"]
        done = CliRunner().invoke(app, [*arguments, "--out", str(folder), "-q", *more])
        assert done.exit_code == 0, done.output
        return folder

    return solve


@pytest.fixture
def browser(tmp_path):
    """Opens HTML text in headless Chromium: the document afterwards, and console messages."""
    found = find_browser()

    def show(html, fragment="", width=1200, *flags):
        path = tmp_path / "page.html"
        path.write_text(html, encoding="utf-8")
        command = [found, "--headless", "--no-sandbox", "--disable-gpu", "--no-first-run"]
        command += ["--disable-background-networking", "--disable-component-update"]
        command += ["--disable-sync", "--disable-extensions", f"--user-data-dir={tmp_path}/profile"]
        command += [f"--window-size={width},1000", "--virtual-time-budget=8000"]
        command += ["--enable-logging=stderr", "--dump-dom", *flags, f"file://{path}{fragment}"]
        done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=True)
        return done.stdout, re.findall(r".*CONSOLE.*", done.stderr)

    return show


@pytest.fixture
def report(solved):
    """The text of the report of a small run."""
    return report_html(solved())
