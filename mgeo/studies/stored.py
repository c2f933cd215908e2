"""A comparison as a folder of CSV files, small enough to be kept beside its documentation."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from mgeo.studies.comparison import Comparison
from mgeo.studies.file import Case
from mgeo.studies.record import Record
from mgeo.studies.space import IndicatorSpace
from mgeo.tables import read_texts, to_csv

TABLE, FINAL, RUNS, FRONTS = "table.csv", "final.csv", "runs.csv", "fronts.csv"
PROVENANCE = "provenance.json"


def stored_tables(comparison: Comparison) -> dict[str, bytes]:
    """The tables from which `read_comparison` makes the same tables and figures again, by file."""
    fronts = [
        pd.DataFrame(record.front_F, columns=list(comparison.objectives)).assign(
            algorithm=name, seed=seed
        )
        for (name, seed), record in comparison.records.items()
    ]
    order = ["algorithm", "seed", *comparison.objectives]
    tables = {
        TABLE: comparison.table,
        FINAL: comparison.final(),
        RUNS: comparison.runs,
        FRONTS: pd.concat(fronts)[order],
    }
    return {name: to_csv(table) for name, table in tables.items()}


def read_comparison(folder: Path | str) -> Comparison:
    """A comparison from the folder into which `run_study` wrote it; nothing is run.

    Its tables, tests and figures are those of the original. Its records hold the final fronts
    and nothing else, and its space no reference front. Where ``fronts.csv`` has not been kept,
    it has no records and no figures of fronts.

    Raises
    ------
    FileNotFoundError
        If there is none.
    ValueError, TypeError
        If its problem is not installed, or a file is not as it was written.
    """
    folder = Path(folder)
    path = folder / PROVENANCE
    if not path.is_file():
        raise FileNotFoundError(f"{folder} holds no comparison: there is no {PROVENANCE}")
    data = json.loads(path.read_text(encoding="utf-8"))
    try:
        case = Case("", data["problem"]["name"], data["problem"]["options"])
        algorithms, n_eval = tuple(data["algorithms"]), int(data["evaluations"])
        stated = data["space"]
        ideal, nadir, point = (
            np.array(stated[key]) for key in ("ideal", "nadir", "reference_point")
        )
        origin = stated["origin"]
    except KeyError as error:
        raise ValueError(f"{path}: {error.args[0]} is missing") from error
    problem = case.build()
    transform = getattr(problem, "indicator_space", None) if origin == "problem" else None
    space = IndicatorSpace(ideal, nadir, point, np.empty((0, problem.n_obj)), origin, transform)
    table, runs = (_read(folder / name) for name in (TABLE, RUNS))
    records = {}
    if (folder / FRONTS).is_file():
        fronts = _read(folder / FRONTS)
        records = {
            (str(row["algorithm"]), int(row["seed"])): _record(row, fronts, n_eval)
            for row in runs.to_dict("records")
            if row["status"] == "finished"
        }
    return Comparison(problem, algorithms, n_eval, table, runs, records, space)


def _read(path: Path) -> pd.DataFrame:
    text = read_texts(path)
    return pd.DataFrame({name: _typed(text[name]) for name in text.columns})


def _typed(column: pd.Series[str]) -> pd.Series[Any]:
    """Integers if all are, or else floats, or else the text."""
    for kind in ("int64", "float64"):
        try:
            return column.astype(object).astype(kind)
        except ValueError:
            continue
    return column


def _record(run: Mapping[Any, Any], fronts: pd.DataFrame, n_eval: int) -> Record:
    own = (fronts["algorithm"] == run["algorithm"]) & (fronts["seed"] == run["seed"])
    F = fronts[own].drop(columns=["algorithm", "seed"]).to_numpy(float)
    return Record(
        numbers=np.full(len(F), n_eval),
        F=F,
        front=np.arange(len(F)),
        X=np.empty((len(F), 0)),
        n_eval=n_eval,
        evaluations=n_eval,
        failed=int(run["failed_evaluations"]),
        wall_time=float(run["wall_time"]),
    )
