"""Files that commands write."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from ..files import write_text
from ..plan import ManeuverPlan, aem_text, to_csv, to_json

SUFFIXES = (".json", ".csv", ".aem")


def checked_targets(paths: Sequence[Path], overwrite: bool, known_only: bool = False) -> None:
    """Refuse files that could not be written, before time is spent on what goes into them.

    Raises
    ------
    ValueError
        For a suffix that is not one of `SUFFIXES`, if these are the only ones, or a file named
        twice.
    OSError
        For a file that is there already, unless `overwrite`, or whose folder is not.
    """
    for path in paths:
        if known_only and path.suffix not in SUFFIXES:
            raise ValueError(f"{path}: expected a name that ends in {', '.join(SUFFIXES)}")
        if list(paths).count(path) > 1:
            raise ValueError(f"{path} is named twice")
        if path.is_dir():
            raise IsADirectoryError(f"{path} is a folder: expected a file")
        if (path.exists() or path.is_symlink()) and not overwrite:
            raise FileExistsError(f"{path} exists: choose another name or allow --overwrite")
        if not path.parent.is_dir():
            raise FileNotFoundError(f"there is no folder {path.parent}")


def check_constraints(plan: ManeuverPlan, force: bool) -> None:
    """Refuse a plan that violates a constraint, unless `force`.

    Raises
    ------
    ValueError
        Naming the constraints and by how much they are violated.
    """
    found = plan.violations()
    if found and not force:
        raise ValueError(
            f"the plan violates {len(found)} of its scenario's constraints ({'; '.join(found)}): "
            "choose another plan or allow --force"
        )


def contents(plan: ManeuverPlan, paths: Sequence[Path], **aem: Any) -> dict[Path, str]:
    """Text of each file by its suffix; `aem` are keywords of `aem_text`."""
    writers = {
        ".json": lambda: to_json(plan),
        ".csv": lambda: to_csv(plan),
        ".aem": lambda: aem_text(plan, **aem),
    }
    return {path: writers[path.suffix]() for path in paths}


def write_all(texts: Mapping[Path, str]) -> Iterator[Path]:
    """Write each file, and say so."""
    for path, text in texts.items():
        write_text(path, text)
        yield path
