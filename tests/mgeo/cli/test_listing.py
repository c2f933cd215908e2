"""Commands ``mgeo problems`` and ``mgeo algorithms``."""

import json
import re

from mgeo.runs.algorithms import complete_parameters
from mgeo.runs.registry import ALGORITHMS


def test_problems_are_listed_although_one_fails_to_load(mgeo):
    lines = mgeo("problems").stdout.splitlines()
    cells = [re.split(r"  +", line.strip()) for line in lines]
    rows = {row[0]: row[1:] for row in cells}
    assert rows["name"] == ["distribution", "version", "variables", "objectives"]
    assert rows["cantilever"] == ["stand-in", "1.2.3", "2", "mass [kg], deflection [m]"]
    assert rows["dtlz2"] == ["stand-in", "1.2.3", "10", "f1, f2, f3"]
    (error,) = [line for line in lines if line.startswith("Error: no-module")]
    assert "No module named 'stand_in_of_nothing'" in error


def test_algorithms_are_listed_with_their_parameters(mgeo, monkeypatch):
    monkeypatch.setenv("COLUMNS", "400")  # Rows must not be wrapped.
    algorithms = json.loads(mgeo("algorithms", "--json").stdout)["algorithms"]
    assert [each["name"] for each in algorithms] == list(ALGORITHMS)
    for each in algorithms:
        assert each["error"] is None
        defaults = json.loads(json.dumps(complete_parameters(each["name"], {})))
        assert {p["name"]: p["default"] for p in each["parameters"]} == defaults
        assert each["label"]
        assert each["description"]
        assert all(p["meaning"] for p in each["parameters"])
    assert re.search(r"^nsga2 +NSGA-II +nondominated sorting", mgeo("algorithms").stdout, re.M)


def test_parameters_of_one_algorithm_are_listed(mgeo):
    text = " ".join(mgeo("algorithms", "mgeo-directed").stdout.split())
    assert text.startswith("mgeo-directed: one weight vector per walker; the default parameter")
    assert "n_walkers 16 " in text
    assert "momentum 0.6,0.6 " in text
