"""A folder of a study: whose it is, and a comparison as CSV files, small enough to be kept."""

from __future__ import annotations

import json
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from pydantic import ConfigDict, Field

from mgeo.plugins import protocol
from mgeo.plugins.problems import load_problem
from mgeo.plugins.protocol import column_names
from mgeo.store.atomic import lock, to_json, write_files
from mgeo.store.provenance import difference
from mgeo.store.reading import read_json, read_texts, to_csv
from mgeo.store.run_folder import STUDY_FILE
from mgeo.store.study_run import StudyRun
from mgeo.studies.comparison import Comparison
from mgeo.studies.file import Study
from mgeo.studies.indicators import OBJECTIVE_SPACE, POINTS, IndicatorSpace, Origin, applicable
from mgeo.studies.labels import folder_name
from mgeo.validation.entries import entry, errors_of
from mgeo.validation.tables import Table, checked

if TYPE_CHECKING:
    from pymoo.core.problem import Problem

TABLE, FINAL, RUNS, FRONTS = "table.csv", "final.csv", "runs.csv", "fronts.csv"
PROVENANCE = "provenance.json"
PATIENCE = 10.0  # seconds for another process that writes there
_INTEGERS = ("seed", "failed_evaluations", "evaluations", "points")

TEXT = "study.toml"


def stored_tables(comparison: Comparison) -> dict[str, bytes]:
    """The tables from which `read_comparison` makes the same tables and figures again, by file."""
    fronts = []
    for (name, seed), record in comparison.records.items():
        front = pd.DataFrame(record.front_F, columns=list(comparison.objectives))
        front.insert(0, "algorithm", name)
        front.insert(1, "seed", seed)
        fronts.append(front)
    tables = {
        TABLE: comparison.table,
        FINAL: comparison.final(),
        RUNS: comparison.runs,
        FRONTS: pd.concat(fronts),
    }
    return {name: to_csv(table) for name, table in tables.items()}


def read_comparison(folder: Path | str, *, named: Collection[str] = ()) -> Comparison:
    """A comparison from the folder into which `run_study` wrote it; nothing is run.

    Its tables, tests and figures are those of the original. Its records hold the final fronts
    and nothing else, and its space no reference front. Where ``fronts.csv`` has not been kept,
    it has no records and no figures of fronts.

    Parameters
    ----------
    folder : of one problem, with ``table.csv`` in it.
    named : problems ``module:Class`` of which modules may be imported: no file has that done.

    Raises
    ------
    FileNotFoundError
        If there is none; of several problems there is one in each folder, see `read_comparisons`.
    ValueError, TypeError
        If its problem is not installed, or a file is not as it was written.

    Examples
    --------
    >>> from pathlib import Path
    >>> from mgeo.studies import read_comparison, read_study, run_study
    >>> text = '''
    ... title = "Two algorithms"
    ... evaluations = 200
    ... grid = 2
    ... seeds = [1, 2]
    ... problems = [{name = "pymoo:zdt1"}]
    ... algorithms = [{name = "mgeo-directed"}, {name = "nsga2"}]
    ... '''
    >>> _ = Path("study.toml").write_text(text)
    >>> _ = run_study(read_study("study.toml"), "results", n_jobs=1, progress=False)
    >>> read_comparison("results").algorithms
    ('mgeo-directed', 'nsga2')
    """
    folder = Path(folder)
    path = folder / PROVENANCE
    if not path.is_file():
        several = " of one problem: see read_comparisons" if (folder / STUDY_FILE).is_file() else ""
        raise FileNotFoundError(f"{folder} holds no comparison{several}: there is no {PROVENANCE}")
    data = read_json(path)
    with errors_of(path):
        told = checked(_Provenance, data)
        problem = load_problem(told.problem.name, told.problem.options, named=named)
        space = _space(problem, told.space)
    algorithms, n_eval = tuple(told.algorithms), told.evaluations
    indicators = [indicator.name for indicator in applicable(problem.n_obj)]
    counts = ["wall_time", "failed_evaluations"]
    table = _read(folder / TABLE, algorithms, ["evaluations", "points", *indicators])
    runs = _read(folder / RUNS, algorithms, counts, ["status", "error"])
    records = {}
    if (folder / FRONTS).exists():
        fronts = _read(folder / FRONTS, algorithms, column_names(problem)[1])
        records = {
            (str(row["algorithm"]), int(row["seed"])): _record(row, fronts, n_eval)
            for row in runs.to_dict("records")
            if row["status"] == "finished"
        }
    return Comparison(problem, algorithms, n_eval, table, runs, records, space)


def read_comparisons(folder: Path | str, *, named: Collection[str] = ()) -> dict[str, Comparison]:
    """Each comparison of a study's folder, by the label of its problem, in the study's order.

    Problems that are not done yet are left out.

    Parameters
    ----------
    folder : into which `run_study` wrote.
    named : as of `read_comparison`.

    Raises
    ------
    FileNotFoundError
        If there is none.
    ValueError, TypeError
        As `read_comparison`.

    Examples
    --------
    >>> from mgeo.studies import read_comparisons
    >>> comparisons = read_comparisons("studies/benchmarks")  # doctest: +SKIP
    >>> comparisons["zdt1"].order()  # doctest: +SKIP
    """
    folder = Path(folder)
    path = folder / STUDY_FILE
    if not path.is_file():
        raise FileNotFoundError(f"{folder} holds no study: there is no {STUDY_FILE}")
    data = read_json(path)
    with errors_of(path):
        labels = list(entry(data, "problems", dict))
    places = {label: folder / folder_name(label) for label in labels}
    if len(labels) == 1:
        places = {labels[0]: folder}
    done = {label: place for label, place in places.items() if (place / PROVENANCE).is_file()}
    if not done:
        raise FileNotFoundError(f"{folder} holds no comparison: none of its problems is done")
    return {label: read_comparison(place, named=named) for label, place in done.items()}


class _Part(Table):
    """What is needed of a table that says more."""

    model_config = ConfigDict(extra="ignore")


class _Problem(_Part):
    name: str
    options: dict[str, Any]


class _Space(_Part):
    origin: Origin
    ideal: list[float] = Field(default_factory=list)
    nadir: list[float] = Field(default_factory=list)
    reference_point: list[float] = Field(default_factory=list)
    parts: list[float] = Field(default_factory=list)  # none by mgeo 0.1
    cuts: list[float] = Field(default_factory=list)


class _Provenance(_Part):
    problem: _Problem
    algorithms: dict[str, Any]
    evaluations: int = Field(ge=1)
    space: _Space


def _space(problem: Problem, stated: _Space) -> IndicatorSpace:
    origin, n_obj = stated.origin, problem.n_obj
    if (origin == "objective") != (n_obj == 1):
        raise ValueError(f"space.origin = {origin!r} with {n_obj} objective(s)")
    if origin == "objective":
        return OBJECTIVE_SPACE
    points = {key: np.array(getattr(stated, key), float) for key in POINTS}
    for key, point in points.items():
        if len(point) != n_obj:
            raise ValueError(f"space.{key} = {point.tolist()!r:.80}: expected {n_obj} numbers")
    if len(stated.parts) != len(stated.cuts):
        raise ValueError(f"space.cuts = {stated.cuts!r:.80}: expected one for each of parts")
    transform = protocol.indicator_space(problem) if origin == "problem" else None
    empty = np.empty((0, n_obj))
    return IndicatorSpace(
        **points,
        reference_front=empty,
        origin=origin,
        transform=transform,
        parts=tuple(stated.parts),
        cuts=tuple(stated.cuts),
    )


def _read(
    path: Path, algorithms: Sequence[str], numbers: Sequence[str], texts: Sequence[str] = ()
) -> pd.DataFrame:
    """A table of runs, with columns of numbers, others of texts, and perhaps more."""
    text = read_texts(path)
    with errors_of(path):
        for name in ("algorithm", "seed", *numbers, *texts):
            if name not in text.columns:
                raise ValueError(f"there is no column {name!r}")
        as_text = {"algorithm", *texts}
        table = pd.DataFrame(
            {name: text[name] if name in as_text else _typed(text[name]) for name in text.columns}
        )
        for name in ("seed", *numbers):
            if table[name].dtype.kind not in ("i" if name in _INTEGERS else "if"):
                raise ValueError(f"column {name}: expected numbers")
        for name in set(table["algorithm"]) - set(algorithms):
            raise ValueError(f"algorithm {name!r:.80}: expected one of {', '.join(algorithms)}")
    return table


def _typed(column: pd.Series[str]) -> pd.Series[Any]:
    """Integers if all are, or else floats, or else the text."""
    for kind in ("int64", "float64"):
        try:
            return column.astype(object).astype(kind)
        except (ValueError, OverflowError):
            continue
    return column


def _record(run: Mapping[Any, Any], fronts: pd.DataFrame, n_eval: int) -> StudyRun:
    own = (fronts["algorithm"] == run["algorithm"]) & (fronts["seed"] == run["seed"])
    F = fronts[own].drop(columns=["algorithm", "seed"]).to_numpy(float)
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


def claim(folder: Path, study: Study) -> None:
    """Make a folder this study's, before it writes tables there; runs belong to anybody.

    It may be so already, also with other seeds or evaluations, and with fewer algorithms or (of
    several) fewer problems: a study may grow.

    Raises
    ------
    ValueError
        If it belongs to another study, with the first difference; nothing is changed then.
    """
    content = _content(study)
    folder.mkdir(parents=True, exist_ok=True)
    with lock(folder, PATIENCE):  # another study's, for the time of a claim
        check(folder, study)
        write_files(folder, {TEXT: study.text.encode(), STUDY_FILE: content})


def check(folder: Path, study: Study) -> None:
    """Refuse a folder that belongs to another study, as `claim` does.

    Raises
    ------
    ValueError
        See `claim`.
    """
    wanted = json.loads(_content(study))
    path = folder / STUDY_FILE
    try:
        found = read_json(path)
    except FileNotFoundError:
        return
    with errors_of(path):
        owner = {key: entry(found, key, dict) for key in wanted}
    if text := _difference(owner, wanted):
        raise ValueError(
            f"{folder} belongs to another study: {text}; expected the problems and algorithms "
            f"in its {STUDY_FILE}, perhaps with more of them, or another folder"
        )


def _content(study: Study) -> bytes:
    try:
        return to_json(study.configuration())
    except (TypeError, ValueError) as error:  # an infinity
        raise ValueError(
            f"options or parameters that JSON cannot hold, and so no provenance: {error}"
        ) from error


def _difference(owner: Mapping[str, Any], wanted: Mapping[str, Any]) -> str:
    for key, known in owner.items():
        for label, expected in known.items():
            if label not in wanted[key]:
                return f"{label!r} is not among the {key}"
            if text := difference(expected, wanted[key][label], f"{key}.{label}"):
                return text
    if len(owner["problems"]) == 1 < len(wanted["problems"]):
        return "it has one problem, whose tables are not in a folder below"
    return ""
