"""Files that commands read and write."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from mgeo.runs.answer import nearest_kept
from mgeo.store.atomic import check_writable
from mgeo.store.run_folder import FRONT_FILE, NEAREST_FILE, RUN_FILE
from mgeo_attitude.plan.files import read_json
from mgeo_attitude.plan.plan import ManeuverPlan
from mgeo_attitude.plan.run_folder import CHOICES, Front, read_front
from mgeo_attitude.view.describe import span, within


@dataclass(frozen=True)
class Picked:
    """A plan, what it is called, and its number on the front of a run, if it is of one.

    A `remark` tells how it is not what was asked for.
    """

    plan: ManeuverPlan
    name: str
    solution: int | None = None
    front: Front | None = None
    remark: str | None = None

    @property
    def answer(self) -> str:
        """What it is worth, in one line."""
        return f"{self.name}: {self.plan.answer}"

    def doubts(self) -> list[str]:
        """Why one might not want to fly it, a line each."""
        hardly = self.plan.uncalibrated()
        said = [self.remark] if self.remark else []
        if hardly:
            said.append(f"this plan hardly calibrates {', '.join(hardly)}")
            said += self._blind()
        return [f"Note: {line}" for line in (*said, *self.plan.scenario.assumed)]

    def _blind(self) -> list[str]:
        """Sensors that never measured until the filter has converged, in a line or none."""
        used = self.plan.sensor_use().drop(columns="duration [s]").sum()
        blind = [str(column).removesuffix(" [s]") for column, time in used.items() if not time]
        if not blind:
            return []
        until = span(self.plan.t_end)
        return [f"{', '.join(blind)} never measured in these {until}, in the dark or out of sight"]

    def lateness(self) -> list[str]:
        """How long the last rate is held, or has to be beyond what is commanded, in a line or none.

        Commands of a plan that promises no time over flights are those of one that is flown
        exactly; most flights may take longer.
        """
        plan, kept = self.plan, self.plan.over_flights.kept
        if plan.scenario.flight:
            return [f"Note: {line}" for line in plan.late()]
        if kept is None or kept <= plan.t_end:
            return []
        ends = "the slew back begins" if plan.slew_back else "commands end"
        hold = ": hold the last rate until then" if kept < math.inf and not plan.slew_back else ""
        if plan.scenario.turned_by_coils:  # it moves freely, whatever is commanded
            hold = ""
        return [
            f"Note: {ends} after {span(plan.t_end)}, when the filter has converged if the plan is "
            f"flown exactly; {within(kept)}{hold}"
        ]


def load_plan(
    source: Path,
    pick: str | None = None,
    time: float | None = None,
    solution: int | None = None,
) -> Picked:
    """Read a plan from its file, or pick one from a run folder: the knee unless told otherwise."""
    given = {"--pick": pick, "--time": time, "--solution": solution}
    flags = [flag for flag, value in given.items() if value is not None]
    if pick is not None and pick not in CHOICES:
        raise ValueError(f"--pick {pick}: expected one of {', '.join(CHOICES)}")
    if len(flags) > 1:
        raise ValueError(f"{' and '.join(flags)}: expected one of them")
    if source.is_dir():
        front = read_front(source)
        number = solution
        if number is None:
            number = front.row(pick or "knee" if time is None else time)
        reason = f", {pick or 'knee'}" if time is None and solution is None else ""
        name = f"solution {number} of {len(front.X)}{reason}"
        if not front.feasible:
            name = f"no plan of this run keeps all limits; nearest solution {number}"
        remark = None if time is None else front.about(time)
        return Picked(front.solution(number), name, number, front, remark)
    if not source.exists():
        raise FileNotFoundError(f"there is neither a run folder nor a plan {source}")
    _check_kind(source)
    if flags:
        raise ValueError(f"{source} is one plan: {flags[0]} is for run folders")
    return Picked(read_json(source), source.name)


def _check_kind(source: Path) -> None:
    """Refuse, with a ValueError, files that are known not to be a plan, with what to type."""
    if source.suffix == ".toml":
        raise ValueError(
            f"{source} is a scenario, not a plan: search one by mgeo solve attitude --scenario "
            f"{source} --out RUN, and name RUN here"
        )
    if (source.parent / RUN_FILE).exists() and source.name in (RUN_FILE, FRONT_FILE, NEAREST_FILE):
        raise ValueError(f"{source} is part of a run, not a plan: name its folder {source.parent}")
    if source.suffix != ".json":
        raise ValueError(
            f"{source} cannot be read back: expected a run folder, or a .json by mgeo attitude "
            "export"
        )


def check_targets(
    paths: Sequence[Path | None], overwrite: bool, suffixes: Sequence[str] = ()
) -> None:
    """Refuse files that could not be written, before time is spent on what goes into them.

    That is a ValueError or OSError; a suffix other than those given is refused, too.
    """
    for path in filter(None, paths):
        if suffixes and not path.name.endswith(tuple(suffixes)):
            raise ValueError(f"{path}: expected a name that ends in {', '.join(suffixes)}")
        if list(paths).count(path) > 1:
            raise ValueError(f"{path} is named twice")
        if path.is_dir():
            raise IsADirectoryError(f"{path} is a folder: expected a file")
        if (path.exists() or path.is_symlink()) and not overwrite:
            raise FileExistsError(f"{path} exists: choose another name or allow --overwrite")
        if not path.parent.is_dir():
            raise FileNotFoundError(f"there is no folder {path.parent}")
        check_writable(path.parent)


def check_constraints(picked: Picked, force: bool) -> None:
    """Refuse, with a ValueError, a plan that violates constraints, unless `force`."""
    found = [] if force else picked.plan.violations()
    if not found:
        return
    front, number = picked.front, None
    if front is not None and picked.solution is not None:
        number = nearest_kept(front.problem.view(front.X), picked.solution)
    other = "" if number is None else f", such as --solution {number},"
    raise ValueError(
        f"the plan violates {len(found)} of its scenario's constraints ({'; '.join(found)}): "
        f"choose another plan{other} or allow --force"
    )
