"""`docs/studies/store.py` keeps what a study found, small."""

import json
import re
import runpy
import tarfile
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from mgeo.studies.file import parse_study, read_study
from mgeo.studies.stored import read_comparison
from mgeo.studies.study import run_study

STUDIES = Path(__file__).parents[2] / "docs" / "studies"
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


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = tmp_path_factory.mktemp("results")
    return folder, run_study(parse_study(STUDY, folder), folder, progress=False)


@pytest.fixture
def store():
    function = runpy.run_path(str(STUDIES / "store.py"))["store"]
    function.__globals__["POINTS"] = POINTS
    return function


@pytest.mark.slow
def test_what_is_kept_reads_back_to_six_digits(results, store, tmp_path):
    source, found = results
    assert {path.name for path in store(source, tmp_path)} == set(found)
    for label, comparison in found.items():
        kept = read_comparison(tmp_path / label)
        assert kept.algorithms == comparison.algorithms
        pd.testing.assert_frame_equal(kept.table, comparison.table, check_exact=False, rtol=5e-6)
        for (name, seed), record in comparison.records.items():
            F = kept.records[name, seed].front_F
            near = np.isclose(F[:, None], record.front_F[None], rtol=5e-6, atol=1e-12).all(axis=2)
            assert near.any(axis=1).all()
            whole = seed == kept.median_seed(name)
            assert len(F) == len(record.front_F) if whole else len(F) <= POINTS
        data = json.loads((tmp_path / label / "provenance.json").read_text())
        assert (data["evaluations"], data["seeds"]) == (300, [1, 2, 3])
        assert data["kept"] == {"digits": 6, "points_of_other_fronts": POINTS}


@pytest.mark.slow
def test_without_fronts_there_are_tables_and_tests(results, store, tmp_path):
    source, found = results
    store(source, tmp_path, fronts=False)
    assert not list(tmp_path.rglob("fronts.csv"))
    kept = read_comparison(tmp_path / "zdt1")
    assert kept.records == {}
    assert set(kept.figures()) == {"anytime", "boxes"}
    pd.testing.assert_frame_equal(kept.tests().pairs, found["zdt1"].tests().pairs)


@pytest.mark.parametrize(
    "path",
    sorted(
        path
        for path in STUDIES.glob("*.toml")
        if path.with_suffix(".md").exists() and path.stem != "coco"  # kept in COCO's own form
    ),
    ids=lambda path: path.stem,
)
def test_results_are_kept_of_every_study_with_a_page(path):
    """Of all its problems and algorithms; their size is what the provenance says."""
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
        assert sum(file.stat().st_size for file in folder.iterdir()) < 2_000_000


def test_data_for_coco_are_kept_of_every_run():
    """Each function's `.info` says how many evaluations were logged of which instance."""
    study = read_study(STUDIES / "coco.toml")
    (algorithm,) = study.algorithms
    found = {}
    with tarfile.open(STUDIES / "data" / "coco" / f"{algorithm.label}.tar.xz") as kept:
        for entry in kept:
            if entry.name.endswith(".info"):
                text = kept.extractfile(entry).read().decode()
                found[entry.name.split("/")[1]] = re.search(r"(\d+):(\d+)\|", text).groups()
    for each in study.problems:
        suite, function, dimension, instance = each.name.removeprefix("coco:").split("/")
        folder = f"{suite}-{function}-{dimension}-{instance}-seed1"
        assert found.pop(folder) == (instance[1:], str(study.evaluations * int(dimension[1:])))
    assert not found
