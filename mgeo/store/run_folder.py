"""Run folders: ``run.json``, ``front.csv``, ``front.npz`` and, without a front, ``nearest.csv``.

``front.csv`` has one row per solution and one column per variable and objective, with exact floats.
``front.npz`` has the constraints and further values of each solution. ``run.json`` has the
configuration and the statistics; it is written last and marks the folder as complete.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import ConfigDict

from mgeo.store.atomic import LOCK_FILE, encode_json, encode_npz, write_file, write_files
from mgeo.store.readers import decode_npz, encode_csv, read_json, read_numeric_table
from mgeo.store.recorder import remove_record
from mgeo.store.run import NearestSolutions, Outcome, Run, RunConfiguration
from mgeo.validation.entries import convert_file_errors, get_entry
from mgeo.validation.tables import Table, validate_table

FORMAT_VERSION = 3
RUN_FILE, FRONT_FILE, ARRAYS_FILE = "run.json", "front.csv", "front.npz"
FIGURE_FILE, REPORT_FILE = "front.html", "report.html"
CHECKPOINT_FILE, RECORD_FOLDER = "run.checkpoint", "evaluations"
#: File of the solutions nearest to feasibility, if no solution is feasible.
NEAREST_FILE = "nearest.csv"
#: Files that a run may write into its folder.
RUN_FILES = (
    *(FRONT_FILE, ARRAYS_FILE, RUN_FILE, NEAREST_FILE, FIGURE_FILE),
    *(CHECKPOINT_FILE, RECORD_FOLDER),
)
#: File of the plan of a study, see `mgeo.studies.plan`.
STUDY_FILE = "study.json"
#: Pattern of the verification files that the tools of a problem write, see `mgeo.report.build`.
VERIFICATION_FILES = "verification*.json"


class RunDocument(Table):
    """Keys of ``run.json`` in addition to those of `mgeo.store.run.Outcome`.

    Attributes
    ----------
    format : int
        Version of the file format.
    configuration : RunConfiguration
        All settings of the run, defaults included.
    versions : dict of str to str
        Versions of Python and of the packages, keyed by name.
    n_solutions : int
        Number of solutions in front.csv.
    n_nearest : int
        Number of solutions in nearest.csv, 0 if a solution is feasible.
    """

    model_config = ConfigDict(extra="ignore")

    format: int
    configuration: RunConfiguration
    versions: dict[str, str]
    n_solutions: int
    n_nearest: int = 0


def check_folder(folder: Path | str, *, overwrite: bool = False) -> Path:
    """Check that a run may be written into a folder, and return the path of the folder.

    The folder need not exist.

    Raises
    ------
    FileExistsError
        If the folder is a file, or is not empty and `overwrite` is false.
    """
    folder = Path(folder)
    if folder.exists() and not folder.is_dir():
        raise FileExistsError(f"{folder} is a file: expected a folder to write the run into")
    names = {path.name for path in folder.iterdir()} if folder.exists() else set()
    if not overwrite and names - {LOCK_FILE}:
        is_unfinished = (folder / CHECKPOINT_FILE).exists() and not (folder / RUN_FILE).exists()
        raise FileExistsError(
            f"{folder} is not empty: choose another folder or allow --overwrite"
            + (f", or continue its run with mgeo resume {folder}" if is_unfinished else "")
        )
    return folder


def write_run(folder: Path | str, run: Run, *, overwrite: bool = False) -> None:
    """Write the files of a run into a folder, and delete outdated figures and reports.

    Raises
    ------
    OSError
        If the folder is not empty (see `check_folder`) or cannot be written.
    """
    folder = check_folder(folder, overwrite=overwrite)
    folder.mkdir(parents=True, exist_ok=True)
    outcome, nearest = run.outcome, run.outcome.nearest
    contents = {
        FRONT_FILE: _encode_table(_list_front_columns(outcome), outcome.X, outcome.F),
        ARRAYS_FILE: _encode_arrays(outcome, outcome.arrays),
    }
    if nearest:
        columns = _list_nearest_columns(outcome)
        contents[NEAREST_FILE] = _encode_table(columns, nearest.X, nearest.F, nearest.violation)
    contents[RUN_FILE] = encode_json(build_run_document(run))
    write_files(folder, contents)
    for name in {NEAREST_FILE, FIGURE_FILE, REPORT_FILE} - contents.keys():
        (folder / name).unlink(missing_ok=True)


def write_arrays(folder: Path, outcome: Outcome, arrays: Mapping[str, NDArray[Any]]) -> None:
    """Rewrite ``front.npz`` in a run folder with additional arrays.

    They replace all earlier additional arrays.

    Parameters
    ----------
    folder : Path
        Run folder.
    outcome : Outcome
        Outcome of the run.
    arrays : mapping of arrays, shape (n, ...)
        Additional arrays, keyed by name.

    Raises
    ------
    OSError
        If the file cannot be written.
    """
    write_file(folder / ARRAYS_FILE, _encode_arrays(outcome, arrays))


def _encode_arrays(outcome: Outcome, arrays: Mapping[str, NDArray[Any]]) -> bytes:
    return encode_npz({**arrays, "X": outcome.X, "F": outcome.F, "G": outcome.G, "H": outcome.H})


def read_run(folder: Path | str) -> Run:
    """Read the configuration, outcome and software versions of a run from its folder.

    Raises
    ------
    FileNotFoundError
        If the folder contains no run.
    FileError
        If a file has invalid content. The message contains the file and the key.
    """
    folder = Path(folder)
    path = folder / RUN_FILE
    if not path.exists():
        raise FileNotFoundError(
            f"{folder} holds no run: there is no {RUN_FILE}. Expected "
            "a folder that `mgeo solve` has written"
        )
    data = read_json(path)
    with convert_file_errors(path):
        file_format = get_entry(data, "format", int)
        if file_format != FORMAT_VERSION:
            raise ValueError(
                f"format = {file_format!r}: this version of mgeo reads format {FORMAT_VERSION}"
            )
        document = validate_table(RunDocument, data)
        arrays = ("X", "F", "G", "H", "arrays", "nearest")  # Separate files contain these fields.
        outcome = validate_table(Outcome, {key: data[key] for key in data if key not in arrays})
    front = _read_table(folder / FRONT_FILE, _list_front_columns(outcome), document.n_solutions)
    X, F = np.hsplit(front, [len(outcome.variables)])
    nearest = NearestSolutions.empty()
    if document.n_nearest:
        table = _read_table(
            folder / NEAREST_FILE, _list_nearest_columns(outcome), document.n_nearest
        )
        sizes = np.cumsum([len(outcome.variables), len(outcome.objectives)])
        nearest = NearestSolutions(*np.hsplit(table, sizes))
    values = _read_arrays(folder / ARRAYS_FILE, document.n_solutions)
    update = {"X": X, "F": F, "G": values.pop("G"), "H": values.pop("H"), "nearest": nearest}
    return Run(
        document.configuration,
        outcome.model_copy(update={**update, "arrays": values}),
        document.versions,
    )


def _read_table(path: Path, columns: list[str], n: int) -> NDArray[np.float64]:
    table = read_numeric_table(path)
    with convert_file_errors(path):
        if list(table.columns) != columns or len(table) != n:
            raise ValueError(
                f"{len(table)} rows and the columns {list(table.columns)}: expected {n} rows and "
                f"{columns}"
            )
    return table.to_numpy(float)


def _read_arrays(path: Path, n: int) -> dict[str, NDArray[Any]]:
    """Read the arrays of ``front.npz``, except those that ``front.csv`` also contains."""
    with convert_file_errors(path):
        arrays = decode_npz(path.read_bytes())
        for key in ("G", "H"):
            if key not in arrays:
                raise ValueError(f"{key} is missing")
        for key, array in arrays.items():
            if not array.ndim or len(array) != n:
                raise ValueError(f"{key} of shape {array.shape}: expected {n} rows")
    return {key: array for key, array in arrays.items() if key not in ("X", "F")}


def _list_front_columns(outcome: Outcome) -> list[str]:
    return [*outcome.variables, *outcome.objectives]


def _list_nearest_columns(outcome: Outcome) -> list[str]:
    return [
        *_list_front_columns(outcome),
        *(f"violation of {name}" for name in outcome.constraints),
    ]


def _encode_table(columns: list[str], *parts: NDArray[np.float64]) -> bytes:
    import pandas as pd

    return encode_csv(pd.DataFrame(np.hstack(parts), columns=columns))


def build_run_document(run: Run) -> dict[str, Any]:
    """Return the content of ``run.json`` as a dict."""
    return {
        "format": FORMAT_VERSION,
        "configuration": run.configuration.model_dump(),
        "n_solutions": len(run.outcome.F),
        "n_nearest": len(run.outcome.nearest),
        **run.outcome.model_dump(mode="json"),
        "versions": dict(run.versions),
    }


def check_verification(content: Any) -> None:
    """Check that verification results have a valid title, conclusion and table.

    The tools of a problem write these results as a JSON file into a run folder, and
    `mgeo.report.build` adds the table to the report of the run.

    Parameters
    ----------
    content
        Content of the JSON file, as returned by `read_json`.

    Raises
    ------
    ValueError, TypeError
        If a key is missing or has an invalid value. The message contains the key.
    """
    for key in ("title", "conclusion"):
        get_entry(content, key, str)
    n = len(get_entry(content, "columns", list[str]))
    for i, row in enumerate(get_entry(content, "rows", list)):
        is_row = isinstance(row, list) and len(row) == n
        if not (is_row and all(isinstance(cell, str | int | float) for cell in row)):
            raise ValueError(f"rows[{i}] = {row!r:.80}: expected {n} numbers or strings")


def remove_run(folder: Path) -> None:
    """Delete the files of a run from a folder, and keep all other files."""
    # run.json is removed first, so that an interruption leaves no invalid run.
    for name in (RUN_FILE, *RUN_FILES, REPORT_FILE):
        if name != RECORD_FOLDER:
            (folder / name).unlink(missing_ok=True)
    remove_record(folder / RECORD_FOLDER)
