"""Files that commands write."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from mgeo_attitude.plan import ManeuverPlan, aem_text, to_csv, to_json

SUFFIXES = (".json", ".csv", ".aem")


def check_targets(
    paths: Sequence[Path], overwrite: bool, suffixes: Sequence[str] | None = None
) -> None:
    """Refuse files that could not be written, before time is spent on what goes into them.

    Raises
    ------
    ValueError
        For a suffix that is not one of `suffixes`, if there are any, or a file named twice.
    OSError
        For a file that is there already, unless `overwrite`, or whose folder is not.
    """
    for path in paths:
        if suffixes and path.suffix not in suffixes:
            raise ValueError(f"{path}: expected a name that ends in {', '.join(suffixes)}")
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
