"""Input and output files of the commands."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from mgeo.store.atomic import check_writable
from mgeo_attitude.plan.files import read_json
from mgeo_attitude.plan.plan import ManeuverPlan
from mgeo_attitude.plan.run_folder import CHOICES, read_front
from mgeo_attitude.view.summaries import format_convergence_time, format_duration


@dataclass(frozen=True)
class SelectedPlan:
    """A plan with its display name, and its solution number if it is from a run folder."""

    plan: ManeuverPlan
    name: str
    solution: int | None = None

    @property
    def summary(self) -> str:
        """One-line summary of the plan."""
        return f"{self.name}: {self.plan.summary}"

    def list_warnings(self) -> list[str]:
        """Return warnings about the plan, one line each."""
        hardly = self.plan.list_uncalibrated_errors()
        lines = [f"this plan hardly reduces the error of {', '.join(hardly)}"] if hardly else []
        return [f"Note: {line}" for line in (*lines, *self.plan.scenario.assumptions)]

    def describe_hold(self) -> list[str]:
        """Return a line on the duration of the constant-rate hold, if it matters.

        The commands of a plan without a robust time are those of its nominal run; most Monte Carlo
        runs may take longer.
        """
        plan = self.plan
        if plan.scenario.monte_carlo:
            return [f"Note: {line}" for line in plan.describe_hold()]
        (kept,) = plan.view.monte_carlo_t_end
        if not kept > plan.t_end:
            return []
        ends = "the slew back begins" if plan.slew_back else "commands end"
        # With magnetorquers, the body moves freely after the last maneuver.
        may_hold = (
            kept < math.inf and not plan.slew_back and not plan.scenario.is_magnetorquer_driven
        )
        hold = ": hold the last rate until then" if may_hold else ""
        return [
            f"Note: {ends} after {format_duration(plan.t_end)}, when the filter has converged in the nominal "
            f"run; {format_convergence_time(kept)}{hold}"
        ]


def load_plan(
    source: Path,
    pick: str | None = None,
    time: float | None = None,
    solution: int | None = None,
) -> SelectedPlan:
    """Read a plan from its file, or select a plan of a run folder, by default the knee.

    Raises
    ------
    OSError
        If the file or folder does not exist or cannot be read.
    ValueError
        If more than one choice is given, or as in `read_front`, `Front.solution` and `read_json`.
    """
    given = {"--pick": pick, "--time": time, "--solution": solution}
    flags = [flag for flag, value in given.items() if value is not None]
    if pick is not None and pick not in CHOICES:
        raise ValueError(f"--pick {pick}: expected one of {', '.join(CHOICES)}")
    if len(flags) > 1:
        raise ValueError(f"{' and '.join(flags)}: expected one of them")
    if source.is_dir():
        front = read_front(source)
        choice = pick or "knee" if time is None else time
        number = front.find_row(choice) if solution is None else solution
        reason = f", {choice}" if isinstance(choice, str) and solution is None else ""
        name = f"solution {number} of {len(front.X)}{reason}"
        if not front.is_feasible:
            name = f"no plan of this run satisfies all constraints; nearest solution {number}"
        return SelectedPlan(front.get_solution(number), name, number)
    if not source.exists():
        raise FileNotFoundError(f"{source}: expected a run folder or a plan file, found neither")
    if source.suffix != ".json":
        raise ValueError(
            f"{source}: expected the run folder of mgeo solve attitude, or a .json file of mgeo "
            "attitude export"
        )
    if flags:
        raise ValueError(f"{source} is a single plan: {flags[0]} applies to run folders only")
    return SelectedPlan(read_json(source), source.name)


def check_targets(
    paths: Sequence[Path | None], overwrite: bool, suffixes: Sequence[str] = ()
) -> None:
    """Check that files can be written, before any results are computed.

    Raises
    ------
    ValueError
        If a suffix is not supported.
    OSError
        If a path is a folder, exists without `overwrite`, or cannot be written.
    """
    for path in filter(None, paths):
        if suffixes and not path.name.endswith(tuple(suffixes)):
            raise ValueError(f"{path}: expected a name that ends in {', '.join(suffixes)}")
        if path.exists() and not (overwrite and path.is_file()):
            raise FileExistsError(f"{path} exists: choose another name or allow --overwrite")
        if not path.parent.is_dir():
            raise FileNotFoundError(f"there is no folder {path.parent}")
        check_writable(path.parent)


def check_constraints(plan: ManeuverPlan) -> None:
    """Raise ValueError if a plan violates constraints."""
    violations = plan.list_violations()
    if violations:
        raise ValueError(
            f"the plan violates {len(violations)} of its scenario's constraints "
            f"({'; '.join(violations)}): choose another plan or allow --force"
        )
