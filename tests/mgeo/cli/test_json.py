"""Option ``--json``: one JSON document on stdout, and all other output on stderr."""

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


def parse_output(done, code=0):
    assert done.exit_code == code, done.output
    return json.loads(done.stdout)


def test_document_of_solve_and_resume(mgeo):
    done = mgeo("solve", "cantilever", *SHORT, "--evaluations", 80, "--out", "a", "--json")
    document = parse_output(done)
    assert document == json.loads(Path("a/run.json").read_text()) | {
        "folder": "a",
        "files": ["front.csv", "front.npz", "run.json", "front.html", "run.checkpoint"],
        "recommended": document["recommended"],
        "front": document["front"],
        "infeasibility": None,
        "warnings": [f"{document['n_solutions']} beams, of steel"],
    }
    recommended, front = document["recommended"], document["front"]
    assert recommended.keys() == {"solution", "label", "summary", "values", "constraints"}
    assert [row["label"] for row in front if row["solution"] == recommended["solution"]] == [
        recommended["label"]
    ]
    F = read_run("a").outcome.F
    assert [row["mass_kg"] for row in front] == F[[row["solution"] for row in front], 0].tolist()
    assert document["hypervolume"] == read_run("a").outcome.hypervolume
    assert "80 of 80 evaluations" in done.stderr
    longer = mgeo("resume", "a", "--evaluations", 160, "--json", "--quiet")
    assert (parse_output(longer)["n_evaluations"], longer.stderr) == (160, "")


@pytest.mark.slow
def test_document_of_study(mgeo):
    Path("one.toml").write_text(STUDY)
    document = parse_output(mgeo("study", "one.toml", "--jobs", 1, "--json"))
    assert (document["folder"], document["seeds"]) == ("studies/one", [1, 2])
    problem = document["problems"]["cantilever"]
    assert (problem["n_finished"], problem["n_failed"]) == (4, 0)
    volumes = {label: each["hypervolume"]["mean"] for label, each in problem["algorithms"].items()}
    assert problem["ranking"] == sorted(volumes, key=volumes.get, reverse=True)
    assert problem["conclusions"][0].startswith(f"{problem['ranking'][0]} ranks first")
    assert [row["algorithm"] for row in document["ranks"]] == problem["ranking"]


class PrintingCantilever(Cantilever):
    """Cantilever problem that prints in each evaluation."""

    def _evaluate(self, X, out, *args, **kwargs):
        print("evaluated")
        super()._evaluate(X, out, *args, **kwargs)


def test_output_of_a_problem_is_not_part_of_the_document(mgeo):
    done = mgeo(
        "solve",
        f"{__name__}:PrintingCantilever",
        *SHORT,
        "--evaluations",
        80,
        "--out",
        "a",
        "--json",
    )
    assert parse_output(done)["n_solutions"] > 0
    assert "evaluated\n" in done.stderr
