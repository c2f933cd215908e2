"""Run folders: ``front.csv``, ``run.json``, ``front.html`` and, without a front, ``nearest.csv``.

``front.csv`` has one row per solution and a column for each variable and objective; floats are
written by repr, so they read back exactly. ``run.json`` says how to make the run again and how it
went; it is written last, so a folder that has it is complete.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from pydantic import ConfigDict

from mgeo.store.atomic import LOCK_FILE, remove_leftovers, replace_files, to_json
from mgeo.store.reading import check_unchanged, read_json, read_numbers, to_csv
from mgeo.store.run import Nearest, Outcome, Run, RunConfiguration
from mgeo.validation.tables import Table, checked, entry, errors_of

if TYPE_CHECKING:
    import pandas as pd

FORMAT = 2
_ARRAYS = ("X", "F", "nearest")  # in files of their own
RUN_FILE, FRONT_FILE = "run.json", "front.csv"
FIGURE_FILE, REPORT_FILE = "front.html", "report.html"
CHECKPOINT_FILE, RECORD_FOLDER = "run.checkpoint", "evaluations"
#: What comes nearest to the constraints, of a run that found nothing that keeps them.
NEAREST_FILE = "nearest.csv"
#: In a study's folder, which holds runs: its problems and algorithms, see `mgeo.studies.stored`.
STUDY_FILE = "study.json"
#: In which a problem's own tools prove a solution of the front, see `mgeo.report.build`.
VERIFICATION_FILES = "verification*.json"
#: Keys by which such a file says what it is about.
ABOUT = ("problem", "options", "design")


class _Document(Table):
    """What ``run.json`` says besides the outcome."""

    model_config = ConfigDict(extra="ignore")

    configuration: RunConfiguration
    versions: dict[str, str]
    solutions: int
    nearest: int = 0


def check_folder(folder: Path | str, *, overwrite: bool = False) -> Path:
    """Refuse a folder that a run could not be written into; nothing is made.

    Raises
    ------
    FileExistsError
        If there is something in it and `overwrite` is not set, or it is a file.
    """
    folder = Path(folder)
    if folder.exists() and not folder.is_dir():
        raise FileExistsError(f"{folder} is a file: expected a folder to write the run into")
    found = {path.name for path in folder.iterdir()} if folder.exists() else set()
    if not overwrite and found - {LOCK_FILE}:
        unfinished = (folder / CHECKPOINT_FILE).exists() and not (folder / RUN_FILE).exists()
        raise FileExistsError(
            f"{folder} is not empty: choose another folder or allow --overwrite"
            + (f", or go on with mgeo resume {folder}" if unfinished else "")
        )
    return folder


def write_run(folder: Path | str, run: Run, *, overwrite: bool = False) -> None:
    """Write ``front.csv``, ``run.json`` and, if need be, ``nearest.csv``, whole or not at all.

    Figure and report of an earlier run in the folder are removed; other files are left alone.

    Raises
    ------
    OSError
        If the folder is in use (see `check_folder`) or cannot be written.
    """
    folder = check_folder(folder, overwrite=overwrite)
    folder.mkdir(parents=True, exist_ok=True)
    document = to_json(run_document(run))
    nearest = {NEAREST_FILE: to_csv(nearest_table(run.outcome))} if run.outcome.nearest else {}
    tables = {FRONT_FILE: to_csv(front_table(run.outcome)), **nearest}
    replace_files(folder, {**tables, RUN_FILE: document})
    if not nearest:
        (folder / NEAREST_FILE).unlink(missing_ok=True)
    for page in (FIGURE_FILE, REPORT_FILE):
        remove_leftovers(folder / page)
        (folder / page).unlink(missing_ok=True)


def read_run(folder: Path | str) -> Run:
    """What `write_run` wrote.

    Raises
    ------
    FileNotFoundError
        If the folder holds no run.
    ValueError
        If a file is not as `write_run` writes it; the message names the file and the key.
    """
    folder = Path(folder)
    path = folder / RUN_FILE
    if not path.exists():
        raise FileNotFoundError(f"{folder} holds no run: there is no {RUN_FILE}")
    data = read_json(path)
    with errors_of(path):
        found = entry(data, "format", int)
        if found != FORMAT:
            raise ValueError(f"format = {found!r}: this version of mgeo reads format {FORMAT}")
        told = checked(_Document, data)
        outcome = checked(Outcome, {key: data[key] for key in data if key not in _ARRAYS})
    front = read_numbers(folder / FRONT_FILE)
    names = [*outcome.variables, *outcome.objectives]
    with errors_of(path):
        if list(front.columns) != names or len(front) != told.solutions:
            raise ValueError(
                f"{FRONT_FILE} has {len(front)} rows and the columns {list(front.columns)}: "
                f"expected {told.solutions} rows and {names}"
            )
        volume, n_obj = outcome.hypervolume, len(outcome.objectives)
        if volume is not None and {len(volume.ideal), len(volume.nadir)} - {0, n_obj}:
            raise ValueError(
                f"hypervolume of ideal {volume.ideal} and nadir {volume.nadir}: expected {n_obj} "
                "numbers each"
            )
    X, F = np.hsplit(front.to_numpy(float), [len(outcome.variables)])
    found = {"X": X, "F": F, "nearest": _read_nearest(folder, outcome, told.nearest)}
    check_unchanged(path, data)
    return Run(told.configuration, outcome.model_copy(update=found), told.versions)


def _read_nearest(folder: Path, outcome: Outcome, n: int) -> Nearest:
    if not n:
        return Nearest.none()
    path = folder / NEAREST_FILE
    table, names = read_numbers(path), _nearest_columns(outcome)
    with errors_of(path):
        if list(table.columns) != names or len(table) != n:
            raise ValueError(
                f"{len(table)} rows and the columns {list(table.columns)}: expected {n} rows and "
                f"{names}"
            )
    sizes = np.cumsum([len(outcome.variables), len(outcome.objectives)])
    return Nearest(*np.hsplit(table.to_numpy(float), sizes))


def front_table(outcome: Outcome) -> pd.DataFrame:
    """The front as a table: one row per solution, variables first."""
    import pandas as pd

    return pd.concat(
        [
            pd.DataFrame(outcome.X, columns=list(outcome.variables)),
            pd.DataFrame(outcome.F, columns=list(outcome.objectives)),
        ],
        axis=1,
    )


def nearest_table(outcome: Outcome) -> pd.DataFrame:
    """What comes nearest to the constraints: variables, objectives, and each violation."""
    import pandas as pd

    nearest = outcome.nearest
    rows = np.hstack([nearest.X, nearest.F, nearest.violation])
    return pd.DataFrame(rows, columns=_nearest_columns(outcome))


def _nearest_columns(outcome: Outcome) -> list[str]:
    violations = (f"violation of {name}" for name in outcome.constraints)
    return [*outcome.variables, *outcome.objectives, *violations]


def run_document(run: Run) -> dict[str, Any]:
    """What ``run.json`` says of a run, as JSON values."""
    return {
        "format": FORMAT,
        "configuration": run.configuration.model_dump(),
        "solutions": len(run.outcome.F),
        "nearest": len(run.outcome.nearest),
        **run.outcome.model_dump(mode="json"),
        "versions": dict(run.versions),
    }


def check_verification(found: Any) -> None:
    """Refuse what is not the content of a verification, see `mgeo.report.build`.

    Raises
    ------
    ValueError, TypeError
        Naming the key.
    """
    for key in ("title", "conclusion"):
        entry(found, key, str)
    n = len(entry(found, "columns", list[str]))
    for i, row in enumerate(entry(found, "rows", list)):
        kept = isinstance(row, list) and len(row) == n
        if not (kept and all(isinstance(cell, str | int | float) for cell in row)):
            raise ValueError(f"rows[{i}] = {row!r:.80}: expected {n} numbers or strings")


def remove_results(folder: Path) -> None:
    """Remove what another run has found."""
    for name in (RUN_FILE, FRONT_FILE, NEAREST_FILE, FIGURE_FILE, REPORT_FILE):
        (folder / name).unlink(missing_ok=True)


def remove_verifications(folder: Path) -> None:
    """Remove what proves a solution of another run; what is only called so is somebody's own."""
    for path in folder.glob(VERIFICATION_FILES):
        try:
            found = read_json(path)
            check_verification(found)
        except (OSError, ValueError, TypeError):
            continue
        if set(ABOUT) <= found.keys():
            path.unlink(missing_ok=True)
