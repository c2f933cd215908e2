"""Fronts that are read from the run folders of ``mgeo solve``, and selection of one plan."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Literal, get_args

import numpy as np

from mgeo.evaluation.dominance import find_front_rows
from mgeo.runs.summary import select_default_solution
from mgeo.store.run_folder import FRONT_FILE, NEAREST_FILE, RUN_FILE, read_run
from mgeo.validation.entries import convert_file_errors
from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.criteria.objectives import PAPER_OBJECTIVES
from mgeo_attitude.plan.plan import ManeuverPlan
from mgeo_attitude.problem import AttitudeManeuverProblem
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.settings.errors import InvalidValue
from mgeo_attitude.view.plans import NominalResults

Choice = Literal["knee", "min-time", "min-trace"]

CHOICES: tuple[Choice, ...] = get_args(Choice)
#: Name under which mgeo registers the problem.
PROBLEM = "attitude"


@dataclass(frozen=True, eq=False)
class Front:
    """Nondominated solutions of an optimization run, with the problem that the run solved.

    If no solution of the run is feasible, the solutions nearest to feasibility take their place.

    Attributes
    ----------
    path : Path
        Path of ``front.csv`` or ``nearest.csv``.
    problem : AttitudeManeuverProblem
    X, F : arrays, shapes (n, n_var) and (n, n_obj)
        Designs and objectives as stored in the file, n >= 1.
    nominal : NominalResults, optional
        Results of the nominal runs, if they are stored in the run folder.
    is_feasible : bool
        Whether the solutions satisfy the constraints. If not, they are the solutions of
        ``nearest.csv``, in ascending order of violation.

    Examples
    --------
    >>> from mgeo_attitude.plan import read_front
    >>> front = read_front("runs/mine")  # doctest: +SKIP
    >>> front.select_plan("knee").build_accuracy_table()  # doctest: +SKIP
    """

    path: Path
    problem: AttitudeManeuverProblem
    X: Floats
    F: Floats
    nominal: NominalResults | None = None
    is_feasible: bool = True

    def select_plan(self, choice: Choice | float) -> ManeuverPlan:
        """Select one solution by a rule such as "knee" or by its convergence time, and return its
        plan.

        Parameters
        ----------
        choice : {"knee", "min-time", "min-trace"} or float
            "knee" is the knee that `mgeo solve` and reports show; without a knee it is the solution
            with the best first objective, and without a feasible solution the one with the
            smallest violation. "min-time" has the smallest t_end, "min-trace" the smallest trace.
            A number selects the solution whose t_end [s] is closest to it.

        Returns
        -------
        ManeuverPlan

        Raises
        ------
        ValueError
            If the choice is unknown, or if the design is out of bounds.
        """
        return self.get_solution(self.find_row(choice))

    def get_solution(self, number: int) -> ManeuverPlan:
        """Return the plan of the solution in a given row of ``front.csv``.

        Rows are counted from 0.

        Objectives and nominal results are taken from the run folder instead of being computed.

        Parameters
        ----------
        number : int
            Row of the solution.

        Returns
        -------
        ManeuverPlan

        Raises
        ------
        ValueError
            If there is no such row, or if the design is out of bounds.
        """
        if not 0 <= number < len(self.X):
            raise ValueError(
                f"solution {number}: expected 0 to {len(self.X) - 1}, the solutions of {self.path}"
            )
        with convert_file_errors(self.path):
            plan = ManeuverPlan.from_design(self.problem, self.X[number], self.F[number])
        if self.nominal is not None:
            plan.view.nominal = NominalResults(*(each[[number]] for each in self.nominal))
        return plan

    def find_row(self, choice: Choice | float) -> int:
        """Return the row in ``front.csv`` of the solution that `select_plan` would select.

        Returns
        -------
        int
        """
        if choice == "knee":
            return select_default_solution(self.problem, self.F).row if self.is_feasible else 0
        rows, t_end = self._rows_by_time
        if choice in ("min-time", "min-trace"):
            return int(rows[0 if choice == "min-time" else -1])
        if isinstance(choice, str) or not math.isfinite(choice):
            choices = f"one of {', '.join(CHOICES)}, or a finite number of seconds"
            raise ValueError(f"choice = {choice!r}: expected {choices}")
        return int(rows[np.argmin(np.abs(t_end - choice))])

    @cached_property
    def _rows_by_time(self) -> tuple[Ints, Floats]:
        """Row numbers of the solutions that are nondominated in t_end and trace, and their t_end.

        The solutions are in ascending order of t_end.
        """
        F = self.F
        if self.problem.objectives != PAPER_OBJECTIVES:
            result = self.nominal or self.problem.evaluate_nominal(self.X)
            F = np.column_stack([result.t_end, result.trace])
        rows = find_front_rows(F)
        return rows, F[rows, 0]


def read_front(folder: Path | str) -> Front:
    """Read the front of an optimization run from the folder of the run.

    Parameters
    ----------
    folder : path
        Folder written by `mgeo solve attitude`.

    Returns
    -------
    Front

    Raises
    ------
    OSError
        If a file is missing or cannot be read.
    ValueError
        If a file is invalid; the message names the file and the key, or the row and column.

    Examples
    --------
    >>> from mgeo_attitude.plan import read_front
    >>> read_front("runs/none")  # doctest: +ELLIPSIS
    Traceback (most recent call last):
        ...
    FileNotFoundError: runs/none holds no run: there is no run.json...
    """
    folder = Path(folder)
    run = read_run(folder)
    outcome, configuration = run.outcome, run.configuration
    with convert_file_errors(folder / RUN_FILE):
        if configuration.problem != PROBLEM:
            name = configuration.problem
            raise InvalidValue("configuration.problem", name, f"expected {PROBLEM!r}")
        try:
            problem = AttitudeManeuverProblem(Scenario.from_dict(configuration.options))
        except InvalidValue as error:
            raise error.prefix_key("configuration.options") from None
    is_feasible = len(outcome.X) > 0
    path = folder / (FRONT_FILE if is_feasible else NEAREST_FILE)
    with convert_file_errors(path):
        columns = [*outcome.variables, *outcome.objectives]
        expected = [*problem.var_names, *problem.obj_names]
        if columns != expected:
            raise ValueError(f"columns {columns}: expected {expected}")
        solutions = outcome if is_feasible else outcome.nearest
        if not solutions:
            raise ValueError("expected at least one row below the header")
    nominal = None
    if is_feasible and outcome.arrays.keys() >= {*NominalResults._fields}:
        nominal = NominalResults(*(outcome.arrays[name] for name in NominalResults._fields))
    return Front(path, problem, solutions.X, solutions.F, nominal, is_feasible)
