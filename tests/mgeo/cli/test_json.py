"""One JSON document on stdout, everything else on stderr."""

import json
from pathlib import Path

import pytest

from mgeo.store.run_folder import read_run

from ..stand_in.stand_in import Cantilever

SHORT = ["--algorithm", "mgeo-real", "--walkers", "4", "--set", "sigma=0.05"]
STUDY = """
title = "One"
evaluations = 60
seeds = 2
[[problems]]
name = "cantilever"
[[algorithms]]
name = ["nsga2", "random"]
population = 10
"""


def document(done, code=0):
    assert done.exit_code == code, done.output
    return json.loads(done.stdout)


def test_solve_and_resume(mgeo):
    done = mgeo("solve", "cantilever", *SHORT, "--evaluations", 80, "--out", "a", "--json")
    found = document(done)
    assert found == json.loads(Path("a/run.json").read_text()) | {
        "folder": "a",
        "files": ["front.csv", "front.npz", "run.json", "front.html", "run.checkpoint"],
        "checkpoint_error": None,
        "summary": found["summary"],
        "infeasibility": None,
        "remarks": [f"{found['n_solutions']} beams, of steel"],
    }
    assert found["summary"].keys() == {"row", "n_solutions", "label", "text", "violations"}
    assert found["hypervolume"] == read_run("a").outcome.hypervolume
    assert "100%  80 of 80 evaluations" in done.stderr
    longer = mgeo("resume", "a", "--evaluations", 160, "--json", "--quiet")
    assert (document(longer)["n_evaluations"], longer.stderr) == (160, "")


@pytest.mark.slow
def test_study(mgeo):
    Path("one.toml").write_text(STUDY)
    found = document(mgeo("study", "one.toml", "--jobs", 1, "--json"))
    assert (found["folder"], found["seeds"]) == ("studies/one", [1, 2])
    one = found["problems"]["cantilever"]
    assert (one["n_finished"], one["n_failed"]) == (4, 0)
    volumes = {label: each["hypervolume"]["mean"] for label, each in one["algorithms"].items()}
    assert one["ranking"] == sorted(volumes, key=volumes.get, reverse=True)
    assert " ranks first: " in one["conclusions"][0]


class Printing(Cantilever):
    """Prints whenever it is evaluated."""

    def _evaluate(self, X, out, *args, **kwargs):
        print("evaluated")
        super()._evaluate(X, out, *args, **kwargs)


def test_what_a_problem_prints_is_not_part_of_the_document(mgeo):
    done = mgeo(
        "solve", f"{__name__}:Printing", *SHORT, "--evaluations", 80, "--out", "a", "--json"
    )
    assert document(done)["n_solutions"] > 0
    assert "evaluated\n" in done.stderr
