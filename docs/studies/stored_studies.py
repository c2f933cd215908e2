"""Stored results of the studies, with the names of problems and algorithms on the pages."""

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pandas as pd

from mgeo.runs.registry import ALGORITHMS
from mgeo.studies import Comparison, Study, read_comparison, read_study
from mgeo.studies.aggregation import compute_average_ranks
from mgeo.studies.comparison_files import select_problem_folders

HERE = Path(__file__).parent
#: Algorithm with which the studies compare all others.
CONTROL = "MGEODirected"
#: Names of algorithms on the pages, by their label in study files and stored results.
_NAMES = {name: record.label for name, record in ALGORITHMS.items()} | {
    "MGEO directed (ours)": CONTROL,
    "directed clip": CONTROL,
    "mgeo-directed": CONTROL,
    "directed reflect": f"{CONTROL}, reflect",
    "directed resample": f"{CONTROL}, resample",
    "ours without momentum": f"{CONTROL}, no momentum",
    "no covariance": f"{CONTROL}, no covariance",
    "MGEO_real clip": "MGEO_real, clip",
    "MGEO_real reflect": "MGEO_real, reflect",
    "MGEO_real σ 1": "MGEO_real, as published",
    "mo-cma-es": "MO-CMA-ES",
    "como-cma-es": "COMO-CMA-ES",
}
#: Label of `MGEODirected` with former constants, which the pages omit.
_FORMER = "ours, any targets"
#: Names of problems on the pages, by their label in study files.
_PROBLEMS = {
    "attitude paper": "paper's satellite",
    "attitude cubesat_6u": "6U CubeSat",
    "attitude paper over flights": "paper's satellite",
    "attitude cubesat_6u over flights": "6U CubeSat",
    "dtlz1 of two objectives": "dtlz1, 2 objectives",
    "dtlz3 of two objectives": "dtlz3, 2 objectives",
}
#: Time at which recombination was added to `MGEODirected`.
_RECOMBINATION = "2026-11-29T03:56"


def format_name(label: str) -> str:
    """Return the name of an algorithm on the pages, from its label in a study."""
    return _NAMES.get(label, label.replace("MGEO_real σ ", "MGEO_real, σ = "))


def load(name: str) -> tuple[Study, dict[str, Comparison]]:
    """Return a study and its stored comparisons by problem label, with algorithms by name."""
    study = read_study(HERE / f"{name}.toml", allow_imports=False)
    comparisons = {
        _PROBLEMS.get(label, label): _rename(read_comparison(place))
        for label, place in locate_results(name, study).items()
    }
    return study, comparisons


def _rename(comparison: Comparison) -> Comparison:
    """Replace the labels of the algorithms by their names."""
    return replace(
        comparison,
        algorithms=tuple(map(format_name, comparison.algorithms)),
        table=comparison.table.assign(algorithm=comparison.table["algorithm"].map(format_name)),
        runs=comparison.runs.assign(algorithm=comparison.runs["algorithm"].map(format_name)),
        finished_runs={
            (format_name(label), seed): run
            for (label, seed), run in comparison.finished_runs.items()
        },
    )


def locate_results(name: str, study: Study) -> dict[str, Path]:
    """Return the folder with the results of each problem, by label."""
    return select_problem_folders(HERE / "data" / name, [case.label for case in study.problems])


def load_values(name: str) -> pd.DataFrame:
    """Return the stored values of a study of many problems, one column per algorithm."""
    values = pd.read_csv(HERE / "data" / name / "values.csv")
    return values.drop(columns=_FORMER, errors="ignore").rename(columns=format_name)


def load_ranks(name: str) -> pd.DataFrame:
    """Return the average ranks of a study of many problems, with tests against the control."""
    return compute_average_ranks(load_values(name), CONTROL)


def load_targets(name: str) -> pd.DataFrame:
    """Return the shares of targets that each algorithm reached in a study of many problems."""
    targets = pd.read_csv(HERE / "data" / name / "targets.csv")
    targets = targets[targets["algorithm"] != _FORMER]
    return targets.assign(algorithm=targets["algorithm"].map(format_name))


def list_earlier_studies(names: Sequence[str]) -> list[str]:
    """Return the studies whose stored results are older than recombination."""
    return [
        name
        for name in names
        if min(read_provenance(path)["written"] for path in (HERE / "data" / name).rglob("prov*"))
        < _RECOMBINATION
    ]


def read_provenance(path: Path) -> dict[str, Any]:
    data: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return data
