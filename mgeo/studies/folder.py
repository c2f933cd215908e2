"""Finished runs on disk."""

from __future__ import annotations

import re
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from mgeo.files.atomic import write_file
from mgeo.files.reading import read_file
from mgeo.studies.dispatch import Key
from mgeo.studies.fingerprint import UncertainError, fingerprint
from mgeo.studies.record import Record
from mgeo.studies.run import Task

_CALLER = 5  # of `compare`, for warnings
_OLD = re.compile(r"-[0-9a-f]{12}-seed\d+\.npz$")  # fingerprints without code


class NotReusedWarning(RuntimeWarning):
    """Runs are not kept, or not used, because it cannot be told what they are runs of."""


class RunFolder:
    """One file per finished run, named after what determines the run.

    A file is there whole or not at all, so a comparison can be killed at any time and go on from
    what is there; several may share a folder. Nothing is ever deleted.
    """

    def __init__(self, folder: Path | str) -> None:
        self.folder = Path(folder)

    def paths(self, tasks: Mapping[Key, Task]) -> dict[Key, Path]:
        """Where the runs are kept, without those that cannot be told from others for certain.

        Warns
        -----
        NotReusedWarning
            Once for each problem or algorithm that cannot, and if the folder holds runs of a
            version of mgeo whose fingerprints said nothing of code.
        """
        prints: dict[int, str] = {}
        found = {}
        for key, task in tasks.items():
            for part in (task.problem, task.algorithm):
                if id(part) not in prints:
                    prints[id(part)] = _print_of(part)
            problem, algorithm = prints[id(task.problem)], prints[id(task.algorithm)]
            if problem and algorithm:
                name = type(task.algorithm).__name__
                known = fingerprint(problem, algorithm, task.n_eval)
                found[key] = self.folder / f"{name}-{known}-seed{task.seed}.npz"
        self._tell_of_old_runs()
        return found

    def read(self, path: Path) -> Record | None:
        """The run, if it is there.

        Raises
        ------
        ValueError
            If the file is damaged.
        """
        try:
            content = read_file(path)
        except FileNotFoundError:
            return None
        try:
            return Record.from_bytes(content)
        except ValueError as error:
            raise ValueError(f"{path}: {error}; delete it to make the run again") from error

    def write(self, path: Path, record: Record) -> None:
        """Keep a run."""
        self.folder.mkdir(parents=True, exist_ok=True)
        write_file(path, record.to_bytes())

    def _tell_of_old_runs(self) -> None:
        if not self.folder.is_dir():
            return
        old = sum(_OLD.search(path.name) is not None for path in self.folder.iterdir())
        if old:
            warnings.warn(
                f"{self.folder} holds runs of an earlier mgeo ({old}), which did not look at the "
                "code of problems: they are not used",
                NotReusedWarning,
                stacklevel=_CALLER,
            )


def _print_of(part: Any) -> str:
    """The fingerprint of a problem or an algorithm; empty, and a warning, if it has none."""
    try:
        return fingerprint(part)
    except UncertainError as error:
        warnings.warn(
            f"{error}: it cannot be told whether a run of {type(part).__name__} is the one asked "
            "for, so such runs are made, but neither kept nor found again; vouch by an attribute "
            f"fingerprint of {type(part).__name__}, a text that says what it computes",
            NotReusedWarning,
            stacklevel=_CALLER,
        )
        return ""
