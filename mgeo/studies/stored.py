"""Files of a finished comparison: tables in CSV and provenance in JSON, written and read back."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Collection, Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from pymoo.core.problem import Problem

from mgeo.plugins import protocol
from mgeo.plugins.problems import load_problem
from mgeo.store.atomic import to_json, write_files
from mgeo.store.reading import exact_floats, read_json, to_csv
from mgeo.studies.comparison import Comparison
from mgeo.studies.indicators import OBJECTIVE_SPACE, POINTS, IndicatorSpace, applicable
from mgeo.studies.plan import PLAN
from mgeo.studies.record import StudyRun
from mgeo.validation.entries import convert_file_errors

TABLE, RUNS, FRONTS = "table.csv", "runs.csv", "fronts.csv"
PROVENANCE = "provenance.json"

_LONGEST = 60  # maximum length of a folder name without the unique suffix
_TAKEN = ("runs",)  # names that a study's folder uses for other content


def write_comparison(
    folder: Path, comparison: Comparison, plan: Mapping[str, Any], more: Mapping[str, bytes] = {}
) -> None:
    """Write the files that `read_comparison` reads, and further files.

    The provenance is written last and marks the comparison as complete.

    Parameters
    ----------
    folder : folder of the problem.
    comparison : the finished comparison.
    plan : provenance without indicator space, notes and run statistics, which are added.
    more : contents of further files by name.
    """
    columns = list(comparison.objectives)
    parts = {key: pd.DataFrame(r.front_F, columns=columns) for key, r in comparison.records.items()}
    fronts = pd.concat(parts, names=["algorithm", "seed"]).reset_index(["algorithm", "seed"])
    tables = {TABLE: comparison.table, RUNS: comparison.runs, FRONTS: fronts}
    runs = comparison.runs
    about = {
        **plan,
        "space": comparison.space.describe(),
        "notes": comparison.notes,
        **{f"runs_{key}": int((runs["status"] == key).sum()) for key in ("finished", "failed")},
        "hours_of_runs": round(float(runs["wall_time"].sum()) / 3600.0, 3),
        "written": datetime.now(UTC).isoformat(timespec="seconds"),
    }
    contents = {name: to_csv(table) for name, table in tables.items()}
    write_files(folder, {**contents, **more, PROVENANCE: to_json(about)})


def read_comparison(
    folder: Path | str, *, problem: Problem | None = None, named: Collection[str] = ()
) -> Comparison:
    """Read a finished comparison from its folder, without running anything.

    Tables, tests and figures equal the original ones. The records contain only the final fronts,
    and the indicator space has no reference front. Without ``fronts.csv``, there are no records and
    no figures of fronts.

    Parameters
    ----------
    folder : folder of one problem, which contains ``table.csv``.
    problem : the compared problem, if `mgeo.compare` was called from Python; None to load the
        problem specified in the study file.
    named : problems ``module:Class`` whose modules may be imported; no other modules are imported
        on behalf of a file.

    Raises
    ------
    FileNotFoundError
        If the folder holds no finished comparison; see `read_comparisons` for several problems.
    ValueError, TypeError
        If the problem is not installed, or a file is damaged.

    Examples
    --------
    >>> from pymoo.algorithms.moo.nsga2 import NSGA2
    >>> from pymoo.problems.multi import ZDT1
    >>> from mgeo import MGEODirected, compare
    >>> from mgeo.studies import read_comparison
    >>> algorithms = {"directed": MGEODirected(), "nsga2": NSGA2(20)}
    >>> problem = ZDT1(n_var=4)
    >>> _ = compare(problem, algorithms, n_eval=500, seeds=3, folder="zdt1", progress=False)
    >>> read_comparison("zdt1", problem=problem).algorithms
    ('directed', 'nsga2')
    """
    folder = Path(folder)
    path = folder / PROVENANCE
    if not path.is_file():
        several = " of one problem: see read_comparisons" if (folder / PLAN).is_file() else ""
        raise FileNotFoundError(f"{folder} holds no comparison{several}: there is no {PROVENANCE}")
    about = read_json(path)
    with convert_file_errors(path):
        try:
            if problem is None:
                problem = _load_problem(about["problem"], named)
            space = _read_space(problem, about["space"])
            algorithms, n_eval = tuple(about["algorithms"]), int(about["evaluations"])
        except KeyError as error:
            raise ValueError(f"{error} is missing") from error
    indicators = [indicator.name for indicator in applicable(problem.n_obj)]
    table = _read_table(folder / TABLE, ["evaluations", "points", *indicators])
    runs = _read_table(folder / RUNS, ["status", "wall_time", "failed_evaluations", "error"])
    records = {}
    if (folder / FRONTS).exists():
        fronts = _read_table(folder / FRONTS, protocol.get_column_names(problem)[1])
        records = {
            (str(row["algorithm"]), int(row["seed"])): _read_record(row, fronts, n_eval)
            for row in runs.to_dict("records")
            if row["status"] == "finished"
        }
    notes = tuple(about.get("notes", ()))
    return Comparison(problem, algorithms, n_eval, table, runs, records, space, notes)


def read_comparisons(folder: Path | str, *, named: Collection[str] = ()) -> dict[str, Comparison]:
    """Read the finished comparisons in the folder of a study, by problem in the order of the study.

    Parameters
    ----------
    folder : folder of `run_study`.
    named : problems ``module:Class`` whose modules may be imported, see `read_comparison`.

    Raises
    ------
    FileNotFoundError
        If the folder holds no finished comparison.
    ValueError, TypeError
        If a problem is not installed, or a file is damaged.

    Examples
    --------
    >>> from mgeo.studies import read_comparisons
    >>> comparisons = read_comparisons("studies/benchmarks")  # doctest: +SKIP
    >>> comparisons["zdt1"].order()  # doctest: +SKIP
    """
    folder = Path(folder)
    path = folder / PLAN
    if not path.is_file():
        raise FileNotFoundError(f"{folder} holds no study: there is no {PLAN}")
    plan = read_json(path)
    labels = list(plan.get("problems", ())) if isinstance(plan, dict) else []
    places = {label: problem_folder(folder, label, len(labels)) for label in labels}
    done = {label: place for label, place in places.items() if (place / PROVENANCE).is_file()}
    if not done:
        raise FileNotFoundError(f"{folder} holds no finished comparison of a study file")
    return {label: read_comparison(place, named=named) for label, place in done.items()}


def problem_folder(folder: Path, label: str, n_problems: int) -> Path:
    """Return the folder of a problem: the study's folder, or its subfolder for several problems."""
    return folder if n_problems == 1 else folder / folder_name(label)


def folder_name(label: str) -> str:
    """Return a unique folder name for a label.

    Labels of lower-case words, digits and underscores only have their spaces replaced by hyphens.
    In other labels, further characters are replaced as well, and the name ends in ``~`` and eight
    hexadecimal digits of a hash.
    """
    plain = re.fullmatch(r"[a-z0-9_]+( [a-z0-9_]+)*", label) and len(label) <= _LONGEST
    if plain and label not in _TAKEN:
        return label.replace(" ", "-")
    readable = re.sub(r"[\W-]+", "-", label.lower())[:_LONGEST].strip("-") or "problem"
    return f"{readable}~{hashlib.sha256(label.encode()).hexdigest()[:8]}"


def _load_problem(about: Mapping[str, Any], named: Collection[str]) -> Problem:
    if "name" not in about:
        raise ValueError(
            "the comparison was made in Python: pass the compared problem as problem=..."
        )
    return load_problem(about["name"], about["options"], trusted_classes=named)


def _read_space(problem: Problem, about: Mapping[str, Any]) -> IndicatorSpace:
    origin, n_obj = about["origin"], problem.n_obj
    if (origin == "objective") != (n_obj == 1):
        raise ValueError(f"space.origin = {origin!r} with {n_obj} objective(s)")
    if n_obj == 1:
        return OBJECTIVE_SPACE
    points = {key: np.array(about[key], float) for key in POINTS}
    return IndicatorSpace(
        **points,
        reference_front=np.empty((0, n_obj)),
        origin=origin,
        transform=protocol.get_indicator_map(problem) if origin == "problem" else None,
        parts=tuple(map(float, about.get("parts", ()))),
        cuts=tuple(map(float, about.get("cuts", ()))),
    )


_TEXTS = ("algorithm", "status", "error", "versions")  # columns of text
_TYPES: dict[str, Any] = dict.fromkeys(_TEXTS, str)


def _read_table(path: Path, columns: Collection[str]) -> pd.DataFrame:
    with convert_file_errors(path):
        table: pd.DataFrame = pd.read_csv(
            path,
            **exact_floats(),
            dtype=_TYPES,
            keep_default_na=False,
            na_values=["nan"],
            index_col=False,
        )
        for name in ("algorithm", "seed", *columns):
            if name not in table:
                raise ValueError(f"there is no column {name!r}")
        for name in set(table.columns) - {*_TEXTS, *table.select_dtypes("number")}:
            raise ValueError(f"column {name}: expected numbers")
    return table


def _read_record(run: Mapping[Any, Any], fronts: pd.DataFrame, n_eval: int) -> StudyRun:
    is_own_row = (fronts["algorithm"] == run["algorithm"]) & (fronts["seed"] == run["seed"])
    F = fronts[is_own_row].drop(columns=["algorithm", "seed"]).to_numpy(float)
    return StudyRun(
        numbers=np.full(len(F), n_eval),
        F=F,
        front=np.arange(len(F)),
        X=np.empty((len(F), 0)),
        n_eval=n_eval,
        evaluations=n_eval,
        failed=int(run["failed_evaluations"]),
        wall_time=float(run["wall_time"]),
    )
