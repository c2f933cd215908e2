"""Finished runs on disk."""

from __future__ import annotations

from pathlib import Path

from mgeo.files import write_file
from mgeo.reading import read_file
from mgeo.studies.fingerprint import fingerprint
from mgeo.studies.record import Record
from mgeo.studies.run import Task


class RunFolder:
    """One file per finished run, named after what determines the run.

    A file is there whole or not at all, so a comparison can be killed at any time and go on from
    what is there; several may share a folder. Nothing is ever deleted.
    """

    def __init__(self, folder: Path | str) -> None:
        self.folder = Path(folder)

    def path(self, task: Task) -> Path:
        """Where the run of this task is kept."""
        key = fingerprint(task.problem, task.algorithm, task.n_eval)
        name = type(task.algorithm).__name__
        return self.folder / f"{name}-{key}-seed{task.seed}.npz"

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
