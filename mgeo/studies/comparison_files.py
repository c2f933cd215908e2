"""Files of a finished comparison: tables in CSV and provenance in JSON."""

from __future__ import annotations

import hashlib
import re
from collections import Counter
from collections.abc import Collection, Iterable, Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from pymoo.core.problem import Problem

from mgeo.plugins import protocol
from mgeo.plugins.problems import load_problem
from mgeo.store.atomic import encode_json, write_files
from mgeo.store.readers import build_exact_float_options, encode_csv, read_json
from mgeo.studies.comparison import Comparison
from mgeo.studies.indicators import (
    POINT_KEYS,
    SINGLE_OBJECTIVE_SPACE,
    IndicatorSpace,
    select_indicators,
)
from mgeo.studies.plan import PLAN_FILE
from mgeo.studies.study_run import StudyRun
from mgeo.validation.entries import convert_file_errors

TABLE_FILE, RUNS_FILE, FRONTS_FILE = "table.csv", "runs.csv", "fronts.csv"
PROVENANCE_FILE = "provenance.json"

_MAX_NAME_LENGTH = 60  # Maximum length of a folder name without the unique suffix.
_RESERVED_NAMES = ("", "runs")  # The folder of a study uses the name runs for other content.


def write_comparison(
    folder: Path,
    comparison: Comparison,
    plan: Mapping[str, Any],
    extra_files: Mapping[str, bytes] = {},
) -> None:
    """Write the tables (CSV) and the provenance (JSON) of a comparison into a folder.

    `read_comparison` reads the folder. The provenance is written last and marks the comparison as
    complete.

    Parameters
    ----------
    folder : Path
        Folder of the problem.
    comparison : Comparison
        Finished comparison.
    plan : mapping
        Provenance without indicator space, notes and run statistics, which are added.
    extra_files : mapping of str to bytes
        Contents of further files by name.
    """
    columns = list(comparison.objectives)
    fronts_by_run = {
        key: pd.DataFrame(r.front_F, columns=columns) for key, r in comparison.finished_runs.items()
    }
    fronts = pd.concat(fronts_by_run, names=["algorithm", "seed"]).reset_index(
        ["algorithm", "seed"]
    )
    tables = {TABLE_FILE: comparison.table, RUNS_FILE: comparison.runs, FRONTS_FILE: fronts}
    runs = comparison.runs
    provenance = {
        **plan,
        "space": comparison.space.describe(),
        "notes": comparison.notes,
        **{f"runs_{key}": int((runs["status"] == key).sum()) for key in ("finished", "failed")},
        "hours_of_runs": round(float(runs["wall_time"].sum()) / 3600.0, 3),
        "written": datetime.now(UTC).isoformat(timespec="seconds"),
    }
    contents = {name: encode_csv(table) for name, table in tables.items()}
    write_files(folder, {**contents, **extra_files, PROVENANCE_FILE: encode_json(provenance)})


def read_comparison(
    folder: Path | str, *, problem: Problem | None = None, trusted_classes: Collection[str] = ()
) -> Comparison:
    """Read a finished comparison from its folder without repeating any runs.

    Tables, tests and figures equal the original ones. The finished runs contain only the final
    fronts, and the indicator space has no reference front. Without ``fronts.csv``, there are no
    finished runs and no figures of fronts.

    Parameters
    ----------
    folder : path
        Folder of one problem, which contains ``table.csv``.
    problem : Problem, optional
        Compared problem, if `mgeo.compare` was called from Python. By default, the problem of the
        study file is built.
    trusted_classes : collection of str
        Problems ``module:Class`` whose modules may be imported. No other modules are imported on
        behalf of a file.

    Returns
    -------
    Comparison
        Comparison stored in the folder.

    Raises
    ------
    FileNotFoundError
        If the folder contains no finished comparison; see `read_comparisons` for several problems.
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
    path = folder / PROVENANCE_FILE
    if not path.is_file():
        hint = " of one problem: see read_comparisons" if (folder / PLAN_FILE).is_file() else ""
        raise FileNotFoundError(
            f"{folder} holds no comparison{hint}: there is no {PROVENANCE_FILE}"
        )
    provenance = read_json(path)
    with convert_file_errors(path):
        try:
            if problem is None:
                problem = _load_problem(provenance["problem"], trusted_classes)
            space = _read_space(problem, provenance["space"])
            algorithms, n_eval = tuple(provenance["algorithms"]), int(provenance["evaluations"])
        except KeyError as error:
            raise ValueError(f"{error} is missing") from error
    indicators = [indicator.name for indicator in select_indicators(problem.n_obj)]
    table = _read_table(folder / TABLE_FILE, ["evaluations", "points", *indicators])
    runs = _read_table(folder / RUNS_FILE, ["status", "wall_time", "failed_evaluations", "error"])
    finished_runs = {}
    if (folder / FRONTS_FILE).exists():
        fronts = _read_table(folder / FRONTS_FILE, protocol.get_column_names(problem)[1])
        finished_runs = {
            (str(row["algorithm"]), int(row["seed"])): _build_study_run(row, fronts, n_eval)
            for row in runs.to_dict("records")
            if row["status"] == "finished"
        }
    notes = tuple(provenance.get("notes", ()))
    return Comparison(problem, algorithms, n_eval, table, runs, finished_runs, space, notes)


def read_comparisons(
    folder: Path | str, *, trusted_classes: Collection[str] = ()
) -> dict[str, Comparison]:
    """Read all finished comparisons of a study, and return them in a dict keyed by problem label.

    The problems are in the order of the study file. Unfinished ones are omitted.

    Parameters
    ----------
    folder : path
        Folder of `run_study`.
    trusted_classes : collection of str
        Problems ``module:Class`` whose modules may be imported, see `read_comparison`.

    Returns
    -------
    dict of str to Comparison
        Comparison of each problem.

    Raises
    ------
    FileNotFoundError
        If the folder contains no finished comparison.
    ValueError, TypeError
        If a problem is not installed, or a file is damaged.

    Examples
    --------
    >>> from mgeo.studies import read_comparisons
    >>> comparisons = read_comparisons("studies/benchmarks")  # doctest: +SKIP
    >>> comparisons["zdt1"].rank_algorithms()  # doctest: +SKIP
    """
    folder = Path(folder)
    path = folder / PLAN_FILE
    if not path.is_file():
        raise FileNotFoundError(f"{folder} holds no study: there is no {PLAN_FILE}")
    plan = read_json(path)
    labels = list(plan.get("problems", ())) if isinstance(plan, dict) else []
    folders = select_problem_folders(folder, labels)
    finished = {
        label: path for label, path in folders.items() if (path / PROVENANCE_FILE).is_file()
    }
    if not finished:
        raise FileNotFoundError(f"{folder} holds no finished comparison of a study file")
    return {
        label: read_comparison(path, trusted_classes=trusted_classes)
        for label, path in finished.items()
    }


def select_problem_folders(folder: Path, labels: Collection[str]) -> dict[str, Path]:
    """Return the folder with the results of each problem of a study, by label.

    The results are in the folder of the study if it has one problem, otherwise in subfolders.
    """
    if len(labels) == 1:
        return dict.fromkeys(labels, folder)
    return {label: folder / name for label, name in format_folder_names(labels).items()}


def format_folder_names(labels: Iterable[str]) -> dict[str, str]:
    """Convert labels to distinct folder names, and return the names by label.

    The names consist of lower-case letters, digits, hyphens and underscores. Names that would be
    equal end in eight hexadecimal digits of a hash.
    """
    names = {
        label: re.sub(r"[^a-z0-9_]+", "-", label.lower())[:_MAX_NAME_LENGTH].strip("-")
        for label in labels
    }
    counts = Counter([*names.values(), *_RESERVED_NAMES])
    return {
        label: name
        if counts[name] == 1
        else f"{name}-{hashlib.sha256(label.encode()).hexdigest()[:8]}".lstrip("-")
        for label, name in names.items()
    }


def _load_problem(description: Mapping[str, Any], trusted_classes: Collection[str]) -> Problem:
    if "name" not in description:
        raise ValueError(
            "the comparison was made in Python: pass the compared problem as the argument problem"
        )
    return load_problem(
        description["name"], description["options"], trusted_classes=trusted_classes
    )


def _read_space(problem: Problem, description: Mapping[str, Any]) -> IndicatorSpace:
    origin, n_obj = description["origin"], problem.n_obj
    if (origin == "objective") != (n_obj == 1):
        raise ValueError(
            f"space.origin = {origin!r} does not match a problem of {n_obj} objective(s)"
        )
    if n_obj == 1:
        return SINGLE_OBJECTIVE_SPACE
    points = {key: np.array(description[key], float) for key in POINT_KEYS}
    return IndicatorSpace(
        **points,
        reference_front=np.empty((0, n_obj)),
        origin=origin,
        transform=protocol.get_indicator_map(problem) if origin == "problem" else None,
        parts=tuple(map(float, description.get("parts", ()))),
        cuts=tuple(map(float, description.get("cuts", ()))),
    )


_TEXT_COLUMNS = ("algorithm", "status", "error", "versions")
_COLUMN_TYPES: dict[str, Any] = dict.fromkeys(_TEXT_COLUMNS, str)


def _read_table(path: Path, columns: Collection[str]) -> pd.DataFrame:
    with convert_file_errors(path):
        table: pd.DataFrame = pd.read_csv(
            path,
            **build_exact_float_options(),
            dtype=_COLUMN_TYPES,
            keep_default_na=False,
            na_values=["nan"],
            index_col=False,
        )
        for name in ("algorithm", "seed", *columns):
            if name not in table:
                raise ValueError(f"the column {name!r} is missing")
        for name in set(table.columns) - {*_TEXT_COLUMNS, *table.select_dtypes("number")}:
            raise ValueError(f"column {name}: expected numbers")
    return table


def _build_study_run(row: Mapping[Any, Any], fronts: pd.DataFrame, n_eval: int) -> StudyRun:
    is_in_run = (fronts["algorithm"] == row["algorithm"]) & (fronts["seed"] == row["seed"])
    F = fronts[is_in_run].drop(columns=["algorithm", "seed"]).to_numpy(float)
    return StudyRun(
        evaluation_numbers=np.full(len(F), n_eval),
        F=F,
        front_rows=np.arange(len(F)),
        X=np.empty((len(F), 0)),
        n_eval=n_eval,
        n_evaluations=n_eval,
        n_failed=int(row["failed_evaluations"]),
        wall_time=float(row["wall_time"]),
    )
