import re

import pytest
from typer.testing import CliRunner

from mgeo.cli.app import app


def listed():
    done = CliRunner().invoke(app, ["problems"])
    assert done.exit_code == 0, done.output
    lines = done.stdout.splitlines()
    rows = [re.split(r"  +", line.strip()) for line in lines]
    return {row[0]: row[1:] for row in rows}, lines


@pytest.mark.usefixtures("stand_in")
def test_what_is_installed_is_listed():
    rows, _ = listed()
    assert rows["name"] == ["distribution", "variables", "objectives"]
    assert rows["cantilever"] == ["stand-in 1.2.3", "2", "mass [kg], deflection [m]"]
    assert rows["dtlz2"] == ["stand-in 1.2.3", "10", "f1, f2, f3"]


@pytest.mark.usefixtures("stand_in")
def test_a_plugin_that_does_not_load_is_listed_with_its_error():
    rows, lines = listed()
    assert rows["no-module"] == ["stand-in 1.2.3", "-", "does not load"]
    (error,) = [line for line in lines if line.startswith("Error: no-module")]
    assert "No module named 'stand_in_of_nothing'" in error
    assert "zdt1" in rows


def test_nothing_installed(monkeypatch):
    monkeypatch.setattr("mgeo.plugins.discovery.entry_points", lambda group: ())
    _, lines = listed()
    assert "pip install mgeo-attitude" in lines[0]
