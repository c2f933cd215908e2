"""Selection of the plan that a command uses, and checks of its output files."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from mgeo.store.atomic import check_writable
from mgeo_attitude.plan.files import read_json
from mgeo_attitude.plan.plan import ManeuverPlan
from mgeo_attitude.plan.run_folder import CHOICES, read_front
from mgeo_attitude.view.summaries import describe_ends


@dataclass(frozen=True)
class SelectedPlan:
    """Plan to which a command applies, with a name for display and its row in the front of a run
    folder.
    """

    plan: ManeuverPlan
    name: str
    solution: int | None = None

    @property
    def summary(self) -> str:
        """One line of text with the name and the convergence time of the plan."""
        return f"{self.name}. {describe_ends(self.plan.view)[0]}"


def load_plan(
    source: Path,
    pick: str | None = None,
    time: float | None = None,
    solution: int | None = None,
) -> SelectedPlan:
    """Load the plan to which a command applies, from a plan file or from a run folder, by default
    the knee of the front.

    Parameters
    ----------
    source : Path
        Run folder of ``mgeo solve`` or plan file.
    pick : {"knee", "min-time", "min-trace"}, optional
        Rule that selects a solution of the run.
    time : float, optional
        Convergence time [s] to which that of the solution is closest.
    solution : int, optional
        Row of the solution.

    Returns
    -------
    SelectedPlan

    Raises
    ------
    OSError
        If the file or folder does not exist or cannot be read.
    ValueError
        If more than one choice is given, if the choice is unknown, or if a file is invalid.
    """
    options = {"--pick": pick, "--time": time, "--solution": solution}
    flags = [flag for flag, value in options.items() if value is not None]
    if pick is not None and pick not in CHOICES:
        raise ValueError(f"--pick {pick}: expected one of {', '.join(CHOICES)}")
    if len(flags) > 1:
        raise ValueError(f"{' and '.join(flags)}: expected one of them")
    if source.is_dir():
        front = read_front(source)
        choice = pick or "knee" if time is None else time
        number = front.find_row(choice) if solution is None else solution
        reason = f" ({choice})" if isinstance(choice, str) and solution is None else ""
        name = f"plan {number} of {len(front.X)}{reason}"
        if not front.is_feasible:
            name = f"no plan of this run satisfies all constraints; nearest plan {number}"
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
    return SelectedPlan(read_json(source), f"plan file {source.name}")


def check_targets(
    paths: Sequence[Path | None], overwrite: bool, suffixes: Sequence[str] = ()
) -> None:
    """Check that all output files can be written, and raise an error otherwise. Commands call this
    function before they compute results.

    Parameters
    ----------
    paths : sequence of Path or None
        Files to write; None is ignored.
    overwrite : bool
        Whether existing files may be replaced.
    suffixes : sequence of str
        Supported suffixes; all suffixes are supported if empty.

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
    """Raise a ValueError that lists the violated constraints of a plan, if there are any."""
    violations = plan.list_violations()
    if violations:
        raise ValueError(
            f"the plan violates {len(violations)} of its scenario's constraints "
            f"({'; '.join(violations)}): choose another plan or allow --force"
        )
