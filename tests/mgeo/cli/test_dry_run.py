"""Option ``--dry-run`` of ``mgeo solve`` and ``mgeo study``."""

import json
import re
from pathlib import Path

import pytest

from mgeo.studies.study_file import read_study

from .test_json import STUDY


def test_dry_run_of_solve_describes_the_run_and_writes_nothing(mgeo):
    Path("four.toml").write_text("n_obj = 4\nn_var = 6\n")
    done = mgeo("solve", "cantilever", "--evaluations", 4000, "--record", "--dry-run")
    assert done.exit_code == 0, done.output
    for line in (
        r"variables +2",
        r"objectives +mass \[kg\], deflection \[m\]",
        r"search +4,000 evaluations",
        r"folder +runs/cantilever-mgeo-directed-seed1",
        r"files +front.csv, front.npz, run.json, front.html, run.checkpoint,",
        r" +evaluations/",
    ):
        assert re.search(rf"^{line}$", done.stdout, re.MULTILINE), line
    arguments = ("solve", "dtlz2", "--scenario", "four.toml", "--algorithm", "nsga3")
    document = json.loads(mgeo(*arguments, "--evaluations", 300, "--dry-run", "--json").stdout)
    assert document["files"] == ["front.csv", "front.npz", "run.json"]
    assert (len(document["objectives"]), document["configuration"]["algorithm"]) == (4, "nsga3")
    assert [path.name for path in Path().iterdir()] == ["four.toml"]


def test_dry_run_reports_invalid_input(mgeo):
    Path("a").mkdir()
    Path("a/mine").touch()
    result = mgeo("solve", "cantilever", "--out", "a", "--dry-run")
    assert result.exit_code == 2
    assert "a is not empty" in result.stderr
    assert mgeo("solve", "cantilevr", "--dry-run").exit_code == 2


def test_dry_run_of_study_imports_no_modules_of_the_file(mgeo):
    Path("untrusted.py").write_text("raise RuntimeError('imported')")
    Path("one.toml").write_text(STUDY.replace('"random"', '"untrusted:Search"'))
    done = mgeo("study", "one.toml", "--jobs", 1, "--dry-run")
    assert done.exit_code == 0, done.output
    assert "untrusted:Search" in done.stdout
    (note,) = done.stderr.splitlines()
    assert note.startswith("Note: untrusted:Search: not checked")
    assert "RuntimeError: imported" in mgeo("study", "one.toml", "--jobs", 1).stderr


def test_dry_run_of_study_describes_the_study_and_writes_nothing(mgeo):
    Path("one.toml").write_text(STUDY)
    document = json.loads(mgeo("study", "one.toml", "--dry-run", "--json").stdout)
    assert [path.name for path in Path().iterdir()] == ["one.toml"]
    assert document["n_runs"] == 4
    assert document["problems"]["cantilever"]["objectives"] == ["mass [kg]", "deflection [m]"]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ([], "Error: studies/one contains a study: continue it with --resume "),
        (["--resume", "--seeds", 1], "Error: studies/one contains another study: seeds = [1], "),
        (["--resume"], ""),
    ],
)
def test_dry_run_of_study_checks_the_folder(mgeo, options, message):
    Path("one.toml").write_text(STUDY)
    plan = read_study(Path("one.toml")).build_plan() | {"versions": {"mgeo": "0.1"}}
    Path("studies/one").mkdir(parents=True)
    Path("studies/one/study.json").write_text(json.dumps(plan))
    done = mgeo("study", "one.toml", "--dry-run", *options)
    assert done.exit_code == (2 if message else 0)
    assert done.stderr.startswith(message)
