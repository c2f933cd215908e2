"""Where solutions are written from the page: into one folder, or to one file, and nothing else."""

from __future__ import annotations

import re
from collections.abc import Mapping
from fnmatch import fnmatch
from pathlib import Path
from typing import Any

from mgeo.store.atomic import to_json, write_file
from mgeo.store.reading import read_json
from mgeo.store.run_folder import RUN_FILE, VERIFICATION_FILES
from mgeo.store.solution_file import is_solution

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,99}\.json")
_PROPOSED = "plan.json"


class Exists(ValueError):
    """A file of that name is there, and nobody said that it may be replaced."""


class Saved:
    """The folder or file that a user said, or the run's folder.

    Raises
    ------
    FileNotFoundError
        If there is no such folder.
    ValueError
        For a file of another ending.
    """

    def __init__(self, folder: Path, said: Path | None) -> None:
        self.only: str | None = None
        self.folder = folder if said is None else said
        if said is not None and not said.is_dir():
            if said.suffix != ".json":
                raise ValueError(f"--save {said}: expected a folder, or a name that ends in .json")
            self.folder, self.only = said.parent, said.name
        if not self.folder.is_dir():
            raise FileNotFoundError(f"--save {said}: there is no folder {self.folder}")

    @property
    def proposal(self) -> Mapping[str, Any]:
        """What the page offers: a name, and whether another may be chosen."""
        return {"name": self.only or _PROPOSED, "fixed": self.only is not None}

    def write(self, name: str, document: Mapping[str, Any], *, overwrite: bool) -> Path:
        """Write a solution's document, whole or not at all, and give its path.

        Raises
        ------
        ValueError
            For a name that is none, or that of another file of a run.
        Exists
            If there is a file, and it is not to be overwritten, or is no solution's.
        OSError
            If it cannot be written.
        """
        if self.only is not None and name != self.only:
            raise ValueError(f"name = {name!r:.80}: expected {self.only}, as --save says")
        if self.only is None:
            taken = name.lower() == RUN_FILE or fnmatch(name.lower(), VERIFICATION_FILES)
            if not _NAME.fullmatch(name) or taken:
                raise ValueError(
                    f"name = {name!r:.80}: expected letters, digits, dots or dashes that end in "
                    f".json, and neither {RUN_FILE} nor {VERIFICATION_FILES}"
                )
        path = self.folder / name
        if path.exists() or path.is_symlink():
            self._check_replaceable(path, overwrite)
        write_file(path, to_json(document))
        return path

    @staticmethod
    def _check_replaceable(path: Path, overwrite: bool) -> None:
        try:
            own = path.is_file() and is_solution(read_json(path))
        except (OSError, ValueError):
            own = False
        if not own:
            raise ValueError(f"{path} is there, and is no solution's file: expected another name")
        if not overwrite:
            raise Exists(f"{path} is there already")
