"""``--dry-run`` writes and evaluates nothing, and describes what would be run."""

import json
import re
from pathlib import Path

from .test_json import STUDY


def test_a_run_is_described_and_nothing_is_written(mgeo):
    Path("four.toml").write_text("n_obj = 4\nn_var = 6\n")
    done = mgeo("solve", "cantilever", "--evaluations", 4000, "--record", "--dry-run")
    assert done.exit_code == 0, done.output
    for line in (
        r"size +variables: 2, objectives: mass \[kg\], deflection \[m\], constraints: 0",
        r"budget +4,000 evaluations",
        r"folder +runs/cantilever-mgeo-directed-seed1",
        r"files +front.csv, front.npz, run.json, front.html, run.checkpoint, evaluations/",
    ):
        assert re.search(rf"^{line} *$", done.stdout, re.MULTILINE), line
    arguments = ("solve", "dtlz2", "--scenario", "four.toml", "--algorithm", "nsga3")
    found = json.loads(mgeo(*arguments, "--evaluations", 300, "--dry-run", "--json").stdout)
    assert found["files"] == ["front.csv", "front.npz", "run.json"]
    assert (len(found["objectives"]), found["configuration"]["algorithm"]) == (4, "nsga3")
    assert [path.name for path in Path().iterdir()] == ["four.toml"]


def test_what_would_be_refused_is_refused(mgeo):
    Path("a").mkdir()
    Path("a/mine").touch()
    refused = mgeo("solve", "cantilever", "--out", "a", "--dry-run")
    assert refused.exit_code == 2
    assert "a is not empty" in refused.stderr
    assert mgeo("solve", "cantilevr", "--dry-run").exit_code == 2


def test_a_dry_run_of_a_study_imports_no_module_that_it_names(mgeo):
    Path("of_a_stranger.py").write_text("raise RuntimeError('imported')")
    Path("one.toml").write_text(STUDY.replace('"random"', '"of_a_stranger:Search"'))
    done = mgeo("study", "one.toml", "--jobs", 1, "--dry-run")
    assert done.exit_code == 0, done.output
    assert "algorithms  nsga2, of_a_stranger:Search" in done.stdout
    (note,) = done.stderr.splitlines()
    assert note.startswith("Note: of_a_stranger:Search: not checked")
    assert "RuntimeError: imported" in mgeo("study", "one.toml", "--jobs", 1).stderr


def test_a_study_is_described_and_nothing_is_written(mgeo):
    Path("one.toml").write_text(STUDY)
    found = json.loads(mgeo("study", "one.toml", "--dry-run", "--json").stdout)
    assert [path.name for path in Path().iterdir()] == ["one.toml"]
    assert found["n_runs"] == 4
    assert found["problems"]["cantilever"]["objectives"] == ["mass [kg]", "deflection [m]"]
