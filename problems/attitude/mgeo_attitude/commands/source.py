"""The plan that a command is about."""

from __future__ import annotations

from pathlib import Path

from mgeo_attitude.plan import ManeuverPlan, read_front, read_json
from mgeo_attitude.plan.run_folder import CHOICES


def load_plan(source: Path, pick: str | None = None, time: float | None = None) -> ManeuverPlan:
    """Read a plan from its file, or pick one from a run folder: the knee unless told otherwise.

    Raises
    ------
    OSError
        If there is no such file or folder, or it cannot be read.
    ValueError
        For contradicting or unknown choices, or a file that does not hold what it should.
    """
    if pick is not None and pick not in CHOICES:
        raise ValueError(f"--pick {pick}: expected one of {', '.join(CHOICES)}")
    if pick is not None and time is not None:
        raise ValueError("--pick and --time: expected one of the two")
    if source.is_dir():
        choice = pick or "knee" if time is None else time
        return read_front(source).plan(choice)
    if not source.exists():
        raise FileNotFoundError(f"there is neither a run folder nor a plan {source}")
    if pick is not None or time is not None:
        raise ValueError(f"{source} is one plan: --pick and --time are for run folders")
    return read_json(source)
