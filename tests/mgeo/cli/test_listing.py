"""Commands ``mgeo problems`` and ``mgeo algorithms``."""

import json
import re

from mgeo.runs.algorithms import complete_parameters
from mgeo.runs.registry import ALGORITHMS


def test_problems_are_listed_although_one_fails_to_load(mgeo):
    done = mgeo("problems")
    rows = [re.split(r"  +", line.strip()) for line in done.stdout.splitlines()]
    assert ["cantilever", "2", "mass [kg], deflection [m]"] in rows
    assert ["dtlz2", "10", "f1, f2, f3"] in rows
    assert ["cantilever", "light", "load of 500 N"] in rows  # a preset
    assert ["attitude", "microsatellite"] in [row[:2] for row in rows]
    errors = done.stderr.splitlines()
    (error,) = [line for line in errors if line.startswith("Error: no-module")]
    assert "No module named 'stand_in_of_nothing'" in error


def test_list_of_algorithms_fits_into_a_terminal(mgeo, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    rows = mgeo("algorithms").stdout.splitlines()
    assert sum(bool(re.match(r"\S+ +(mgeo|pymoo) ", row)) for row in rows) == len(ALGORITHMS)
    assert len(rows) == len(ALGORITHMS) + 3  # head, empty line and hint: no row is wrapped
    assert max(map(len, rows)) <= 80


def test_algorithms_are_listed_with_their_parameters(mgeo):
    algorithms = json.loads(mgeo("algorithms", "--json").stdout)["algorithms"]
    assert [each["name"] for each in algorithms] == list(ALGORITHMS)
    for each in algorithms:
        assert each["error"] is None
        defaults = json.loads(json.dumps(complete_parameters(each["name"], {})))
        assert {p["name"]: p["default"] for p in each["parameters"]} == defaults
        assert each["label"]
        assert each["description"]
        assert all(p["meaning"] for p in each["parameters"])
    libraries = {each["name"]: each["library"] for each in algorithms}
    assert (libraries["mgeo-real"], libraries["rvea"]) == ("mgeo", "pymoo")


def test_parameters_of_one_algorithm_are_listed(mgeo):
    text = " ".join(mgeo("algorithms", "mgeo-directed").stdout.split())
    assert text.startswith("mgeo-directed: decomposition-based MGEO")
    for parameter in complete_parameters("mgeo-directed", {}):
        assert f" {parameter} = " in text
    assert "momentum = 0.6,0.6 " in text


def test_parameters_are_described_in_terms_of_the_command_line(mgeo):
    for name in ALGORITHMS:
        assert "`" not in mgeo("algorithms", name).stdout
    assert "as for mgeo-real" in mgeo("algorithms", "mgeo-real2").stdout
