import inspect
import json
import re

import pytest
from typer.testing import CliRunner

from mgeo import MGEODirected
from mgeo.cli.app import app
from mgeo.runs.algorithms import ALGORITHMS, complete_parameters


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
    assert "pip install ./problems/attitude" in lines[0]


def test_every_algorithm_is_listed_with_what_it_takes(mgeo, monkeypatch):
    monkeypatch.setenv("COLUMNS", "400")  # a row is a line
    found = json.loads(mgeo("algorithms", "--json").stdout)["algorithms"]
    assert [each["name"] for each in found] == list(ALGORITHMS)
    for each in found:
        assert each["error"] is None
        defaults = json.loads(json.dumps(complete_parameters(each["name"], {})))
        assert {p["name"]: p["default"] for p in each["parameters"]} == defaults
        assert each["about"]
        assert all(p["meaning"] for p in each["parameters"])
    shown = mgeo("algorithms").stdout
    assert re.search(r"^nsga2 +pymoo\.algorithms\.moo\.nsga2\.NSGA2 *$", shown, re.MULTILINE)
    assert re.search(
        r"^mgeo-real +Multiobjective .*, real-coded \(MGEO_real\)", shown, re.MULTILINE
    )


def test_one_algorithm_says_what_its_class_says(mgeo):
    lines = mgeo("algorithms", "mgeo-directed").stdout.splitlines()
    assert lines[0].startswith("mgeo-directed: ")
    text = " ".join(" ".join(lines).split())
    assert "--walkers 16 " in text
    assert "momentum 0.6,0.6 " in text
    assert inspect.getdoc(MGEODirected).partition("\n")[0] in text
    refused = mgeo("algorithms", "mgeo-directid")
    assert refused.exit_code == 2
    assert "did you mean 'mgeo-directed'?" in refused.stderr


def test_an_algorithm_that_does_not_load_does_not_hide_the_others(mgeo, monkeypatch):
    names = [*ALGORITHMS, "nowhere:Class"]
    monkeypatch.setattr("mgeo.runs.algorithms.algorithm_names", lambda: names)
    done = mgeo("algorithms")
    assert done.exit_code == 0
    assert "Error: nowhere:Class: algorithm 'nowhere:Class' does not load" in done.stdout
    assert "mgeo-real2" in done.stdout
