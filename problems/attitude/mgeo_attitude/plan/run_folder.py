"""Fronts from the run folders of ``mgeo solve``, and the plan to fly from one.

Nothing in a folder is trusted: what is read is checked, and the plan picked is computed anew.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Literal, get_args

import numpy as np

from mgeo.evaluation.dominance import front_rows
from mgeo.runs.answer import default_solution
from mgeo.store.run_folder import FRONT_FILE, NEAREST_FILE, RUN_FILE, read_run
from mgeo.validation.tables import errors_of
from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.plan.plan import ManeuverPlan
from mgeo_attitude.problem import AttitudeManeuverProblem
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.scenario.settings import PAPER
from mgeo_attitude.settings.errors import InvalidValue

Choice = Literal["knee", "fastest", "best"]

CHOICES: tuple[Choice, ...] = get_args(Choice)
#: A plan ends at a time that is asked for if it is off by no more than this fraction.
_NEAR = 0.01
#: Objectives computed again, perhaps by other libraries, may differ by this fraction.
TOLERANCE = 1e-6
#: Name of this problem among those of mgeo.
PROBLEM = "attitude"


@dataclass(frozen=True, eq=False)
class Front:
    """The solutions of a run.

    Attributes
    ----------
    path : Path
        Of ``front.csv`` or ``nearest.csv``.
    problem : AttitudeManeuverProblem
    X, F : arrays, shapes (n, n_var) and (n, n_obj)
        n >= 1 designs, and the problem's objectives as the file has them.
    feasible : bool
        Whether they keep the scenario's limits; if not they are those of ``nearest.csv``, the
        nearest first.

    Examples
    --------
    >>> from mgeo_attitude.plan import read_front
    >>> front = read_front("runs/mine")  # doctest: +SKIP
    >>> front.plan("knee").accuracy()  # doctest: +SKIP
    """

    path: Path
    problem: AttitudeManeuverProblem
    X: Floats
    F: Floats
    feasible: bool = True

    def plan(self, choice: Choice | float) -> ManeuverPlan:
        """Pick a solution of the front.

        Parameters
        ----------
        choice : {"knee", "fastest", "best"} or float
            The bend of the front as `mgeo solve` and reports show it (the best of the first
            objective if it does not bend, the nearest if none is feasible), its least t_end, its
            least trace, or the solution whose t_end is nearest to a number of seconds.

        Raises
        ------
        ValueError
            For another choice, or as `solution`.
        """
        return self.solution(self.row(choice))

    def solution(self, number: int) -> ManeuverPlan:
        """The plan of a solution by its number, from 0 in the order of ``front.csv``.

        Raises
        ------
        ValueError
            For a number that none has, or a solution whose objectives are not those in the file:
            somebody has edited it, or it is of a version of this package that computed otherwise.
        """
        if not 0 <= number < len(self.X):
            raise ValueError(f"solution {number}: expected 0 to {len(self.X) - 1}")
        with errors_of(self.path):
            plan = ManeuverPlan.from_design(self.problem, self.X[number])
            values = self.problem.evaluate(self.X[number], return_values_of=["F"]).tolist()
            for name, value, found in zip(
                self.problem.obj_names, self.F[number], values, strict=True
            ):
                if not math.isclose(value, found, rel_tol=TOLERANCE):
                    raise InvalidValue(
                        f"row {number + 1}, {name}",
                        float(value),
                        f"expected {found!r}, which the filter gives for this design",
                    )
        return plan

    def row(self, choice: Choice | float) -> int:
        """Number of the solution that `plan` picks."""
        if isinstance(choice, str) and choice not in CHOICES:
            raise ValueError(f"choice = {choice!r}: expected one of {', '.join(CHOICES)}")
        if not (isinstance(choice, str) or math.isfinite(choice)):
            raise ValueError(f"choice = {choice!r}: expected a finite number of seconds")
        if choice == "knee":
            if not self.feasible:
                return 0
            return default_solution(self.problem, self.F).row
        rows, t_end = self._by_time
        if isinstance(choice, str):
            return int(rows[{"fastest": 0, "best": -1}[choice]])
        return int(rows[np.argmin(np.abs(t_end - choice))])

    def about(self, seconds: float) -> str | None:
        """How the plan whose t_end is nearest to a time [s] is not what one might expect of it.

        None if it ends then, to a hundredth.
        """
        rows, t_end = self._by_time
        nearest = int(np.argmin(np.abs(t_end - seconds)))
        asked, found = f"{seconds:.6g} s", f"{t_end[nearest]:.6g} s"
        if abs(t_end[nearest] - seconds) <= _NEAR * abs(seconds):
            return None
        if t_end[nearest] > seconds:
            if nearest == 0:
                return f"no plan of this front converges by {asked}: the first takes {found}"
            row, before = rows[nearest - 1], t_end[nearest - 1]
            return (
                f"this plan converges after {found}, not by {asked}; the last that does so is "
                f"--solution {row}, after {before:.6g} s"
            )
        if nearest == len(rows) - 1:
            return (
                f"nothing is gained by waiting until {asked}: this plan leaves the least trace of "
                f"this front, after {found}"
            )
        return (
            f"this plan, after {found}, is the last that converges by {asked}; the next one does "
            f"after {t_end[nearest + 1]:.6g} s"
        )

    @cached_property
    def _by_time(self) -> tuple[Ints, Floats]:
        """Rows that no other beats in both t_end and trace, and their t_end, ascending."""
        if self.problem.objectives == PAPER:
            F = self.F
        else:
            result = self.problem.run(self.X)
            F = np.column_stack([result.t_end, result.trace])
        rows = front_rows(F)
        return rows, F[rows, 0]


def read_front(folder: Path | str) -> Front:
    """Read a run folder.

    Parameters
    ----------
    folder : path
        That `mgeo solve attitude` wrote.

    Raises
    ------
    OSError
        If a file is missing or cannot be read.
    ValueError
        Naming the file and what is wrong in it: the key, or the row and column.

    Examples
    --------
    >>> from mgeo_attitude.plan import read_front
    >>> read_front("runs/none")
    Traceback (most recent call last):
        ...
    FileNotFoundError: runs/none holds no run: there is no run.json
    """
    folder = Path(folder)
    run = read_run(folder)
    outcome, configuration, path = run.outcome, run.configuration, folder / FRONT_FILE
    with errors_of(folder / RUN_FILE):
        if configuration.problem != PROBLEM:
            name = configuration.problem
            raise InvalidValue("configuration.problem", name, f"expected {PROBLEM!r}")
        try:
            problem = AttitudeManeuverProblem(Scenario.from_dict(configuration.options))
        except InvalidValue as error:
            raise error.under("configuration.options") from None
    with errors_of(path):
        found = [*outcome.variables, *outcome.objectives]
        expected = [*problem.var_names, *problem.obj_names]
        if found != expected:
            raise ValueError(f"columns {found}: expected {expected}")
        if not len(outcome.X) and not outcome.nearest:
            raise ValueError("expected at least one row below the header")
    if not len(outcome.X):
        nearest = outcome.nearest
        return Front(folder / NEAREST_FILE, problem, nearest.X, nearest.F, feasible=False)
    return Front(path, problem, outcome.X, outcome.F)
