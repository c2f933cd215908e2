"""Files that commands read and write."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from mgeo_attitude.plan import ManeuverPlan, read_front, read_json
from mgeo_attitude.plan.run_folder import CHOICES

SUFFIXES = (".json", ".csv", ".aem")


def load_plan(source: Path, pick: str | None = None, time: float | None = None) -> ManeuverPlan:
    """Read a plan from its file, or pick one from a run folder: the knee unless told otherwise."""
    if pick is not None and pick not in CHOICES:
        raise ValueError(f"--pick {pick}: expected one of {', '.join(CHOICES)}")
    if pick is not None and time is not None:
        raise ValueError("--pick and --time: expected one of the two")
    if source.is_dir():
        return read_front(source).plan(pick or "knee" if time is None else time)
    if not source.exists():
        raise FileNotFoundError(f"there is neither a run folder nor a plan {source}")
    if pick is not None or time is not None:
        raise ValueError(f"{source} is one plan: --pick and --time are for run folders")
    return read_json(source)


def check_targets(paths: Sequence[Path | None], overwrite: bool, plans: bool = False) -> None:
    """Refuse files that could not be written, before time is spent on what goes into them.

    That is a ValueError or OSError; a suffix other than those of `plans` is refused, too.
    """
    for path in filter(None, paths):
        if plans and path.suffix not in SUFFIXES:
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
    """Refuse, with a ValueError, a plan that violates constraints, unless `force`."""
    found = plan.violations()
    if found and not force:
        raise ValueError(
            f"the plan violates {len(found)} of its scenario's constraints ({'; '.join(found)}): "
            "choose another plan or allow --force"
        )
