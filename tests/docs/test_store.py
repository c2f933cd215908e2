"""Stored results of studies, and `docs/studies/store.py`, which writes them."""

import json
import runpy

import numpy as np
import pandas as pd
import pytest

from mgeo.studies.comparison_files import read_comparison
from mgeo.studies.study import run_study
from mgeo.studies.study_file import parse_study, read_study

from .pages import DOCS, blocks

STUDIES = DOCS / "studies"
POINTS = 5

STUDY = """
title = "two"
evaluations = 300
seeds = 3
grid = 2
[[problems]]
name = ["pymoo:zdt1", "pymoo:zdt2"]
[[algorithms]]
name = ["nsga2", "random"]
label = "{name}"
population = 20
"""


def test_the_study_file_of_the_page_on_studies_is_read():
    text, _ = blocks("studies/README.md", "toml")
    study = parse_study(text, STUDIES)
    assert study.compute_budget(study.problems[0].build())[0] == 20_000
    assert study.control in [algorithm.label for algorithm in study.algorithms]


@pytest.mark.slow
def test_study_on_the_class_of_the_page_on_studies_runs(tmp_path, monkeypatch):
    (module,) = blocks("studies/README.md", "python")
    _, text = blocks("studies/README.md", "toml")
    (tmp_path / "mast.py").write_text(module)
    monkeypatch.syspath_prepend(tmp_path)
    study = parse_study(text.replace("2_000", "200").replace("seeds = 5", "seeds = 2"), tmp_path)
    (comparison,) = run_study(study, tmp_path / "out", progress=False, n_jobs=1).values()
    assert (comparison.select_final_rows()["hypervolume"] > 0.0).all()


@pytest.mark.slow
@pytest.mark.parametrize("fronts", [True, False])
def test_stored_results_agree_to_six_digits(fronts, tmp_path):
    source, kept = tmp_path / "source", tmp_path / "kept"
    results = run_study(parse_study(STUDY, source), source, progress=False)
    store = runpy.run_path(str(STUDIES / "store.py"))["store"]
    store.__globals__["POINTS"] = POINTS
    assert {path.name for path in store(source, kept, fronts=fronts)} == set(results)
    for label, comparison in results.items():
        stored = read_comparison(kept / label)
        pd.testing.assert_frame_equal(stored.table, comparison.table, check_exact=False, rtol=5e-6)
        pd.testing.assert_frame_equal(
            stored.test_differences().pairs, comparison.test_differences().pairs
        )
        assert set(stored.finished_runs) == (set(comparison.finished_runs) if fronts else set())
        for (name, seed), record in stored.finished_runs.items():
            whole = comparison.finished_runs[name, seed].front_F
            near = np.isclose(record.front_F[:, None], whole[None], rtol=5e-6, atol=1e-12).all(
                axis=2
            )
            assert near.any(axis=1).all()
            is_median = seed == stored.find_median_seed(name)
            assert len(record.front_F) == (len(whole) if is_median else min(len(whole), POINTS))


@pytest.mark.parametrize(
    "path",
    sorted(
        path
        for path in STUDIES.glob("*.toml")
        if path.with_suffix(".md").exists() and path.stem != "coco"  # stored in COCO's own format
    ),
    ids=lambda path: path.stem,
)
def test_stored_results_belong_to_their_study(path):
    """Every problem and algorithm has results, of the size that the provenance states."""
    study = read_study(path)
    folders = sorted(p.parent for p in (STUDIES / "data" / path.stem).rglob("provenance.json"))
    assert len(folders) == len(study.problems)
    for folder in folders:
        data = json.loads((folder / "provenance.json").read_text(encoding="utf-8"))
        assert list(data["algorithms"]) == [each.label for each in study.algorithms]
        runs = pd.read_csv(folder / "runs.csv")
        assert (runs["status"] == "finished").sum() == data["runs_finished"]
        assert len(runs) == len(data["seeds"]) * len(data["algorithms"])
        table = pd.read_csv(folder / "table.csv")
        assert table["evaluations"].max() == data["evaluations"]
