"""Fronts from the run folders of ``mgeo solve``, and the plan to fly from one.

A run folder is two public text files: ``run.json``, which says what was solved, and ``front.csv``,
one row per solution with a column for each variable and objective. Nothing in them is trusted: what
is read is checked, and the plan picked is computed anew.
"""

from __future__ import annotations

import math
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from ..describe import nondominated
from ..fields import InvalidValue
from ..figures.solutions import knee
from ..filter.evaluator import evaluate
from ..objectives import indicators
from ..problem import AttitudeManeuverProblem
from ..scenario import Scenario
from ..scenario.objective_names import PAPER
from .plan import ManeuverPlan
from .reading import (
    TOLERANCE,
    errors_of,
    parse_csv,
    parse_json,
    parse_number,
    read_text,
)

Floats = NDArray[np.float64]
Choice = Literal["knee", "fastest", "best"]

CHOICES: tuple[Choice, ...] = get_args(Choice)
FORMAT = 1
RUN_FILE, FRONT_FILE = "run.json", "front.csv"

#: Name of this problem among those of mgeo.
PROBLEM = "attitude"


@dataclass(frozen=True, eq=False)
class Front:
    """The solutions of a run.

    Attributes
    ----------
    path : Path
        Of ``front.csv``.
    problem : AttitudeManeuverProblem
    X, F : arrays, shapes (n, n_var) and (n, n_obj)
        n >= 1 designs, and the problem's objectives as the file has them.
    """

    path: Path
    problem: AttitudeManeuverProblem
    X: Floats
    F: Floats

    def plan(self, choice: Choice | float) -> ManeuverPlan:
        """Pick a solution of the front.

        Parameters
        ----------
        choice : {"knee", "fastest", "best"} or float
            The bend of the front in the problem's indicator space, its least t_end, its least
            trace, or the solution whose t_end is nearest to a number of seconds.

        Raises
        ------
        ValueError
            For another choice, or a solution whose objectives are not those in the file: somebody
            has edited it, or it is of a version of this package that computed otherwise.
        """
        row = self.row(choice)
        with errors_of(self.path):
            plan = ManeuverPlan.from_design(self.problem, self.X[row])
            if self.problem.objectives == PAPER:
                values = (plan.t_end, plan.trace)
            else:
                values = tuple(self.problem.evaluate(self.X[row], return_values_of=["F"]).tolist())
            for name, value, found in zip(self.problem.obj_names, self.F[row], values, strict=True):
                if not math.isclose(value, found, rel_tol=TOLERANCE):
                    raise InvalidValue(
                        f"row {row + 1}, {name}",
                        float(value),
                        f"expected {found!r}, which the filter gives for this design",
                    )
        return plan

    def row(self, choice: Choice | float) -> int:
        """Row, from 0, of the solution that `plan` picks."""
        times_and_traces = self._times_and_traces()
        rows = nondominated(times_and_traces)
        front = times_and_traces[rows]
        if isinstance(choice, str):
            if choice not in CHOICES:
                raise ValueError(f"choice = {choice!r}: expected one of {', '.join(CHOICES)}")
            bend = knee(indicators(PAPER, front, self.problem.scenario))
            return int(rows[{"knee": bend, "fastest": 0, "best": -1}[choice]])
        if not math.isfinite(choice):
            raise ValueError(f"choice = {choice!r}: expected a finite number of seconds")
        return int(rows[np.argmin(np.abs(front[:, 0] - choice))])

    def _times_and_traces(self) -> Floats:
        """t_end [s] and trace of each solution, shape (n, 2), whatever was minimized."""
        if self.problem.objectives == PAPER:
            return self.F
        result = evaluate(self.problem.model, self.X, self.problem.threads)
        return np.column_stack([result.t_end, result.trace])


def read_front(folder: str | os.PathLike[str]) -> Front:
    """Read a run folder.

    Raises
    ------
    OSError
        If a file is missing or cannot be read.
    ValueError
        Naming the file and what is wrong in it: the key, or the row and column.
    """
    folder = Path(folder)
    run, front = folder / RUN_FILE, folder / FRONT_FILE
    if not run.exists():
        raise FileNotFoundError(f"{folder} holds no run: there is no {RUN_FILE}")
    with errors_of(run):
        problem = _problem(parse_json(read_text(run)))
    with errors_of(front):
        table = _table(read_text(front), [*problem.var_names, *problem.obj_names])
        return Front(front, problem, table[:, : problem.n_var], table[:, problem.n_var :])


def _problem(data: Any) -> AttitudeManeuverProblem:
    recipe = _entry(data, "", "recipe")
    version = _entry(data, "", "format")
    if version != FORMAT or isinstance(version, bool):
        raise InvalidValue("format", version, f"this package reads format {FORMAT}")
    name, options = (_entry(recipe, "recipe.", key) for key in ("problem", "options"))
    if name != PROBLEM:
        raise InvalidValue("recipe.problem", name, f"expected {PROBLEM!r}")
    if not isinstance(options, dict):
        raise InvalidValue("recipe.options", options, "expected an object")
    try:
        return AttitudeManeuverProblem(Scenario.from_dict(options))
    except InvalidValue as error:
        raise error.under("recipe.options") from None


def _entry(table: Any, place: str, key: str) -> Any:
    if not isinstance(table, dict) or key not in table:
        raise ValueError(f"{place}{key} is missing")
    return table[key]


def _table(text: str, names: list[str]) -> Floats:
    rows = [
        [parse_number(f"row {i}, {name}", cell) for name, cell in zip(names, row, strict=True)]
        for i, row in enumerate(parse_csv(text, names), 1)
    ]
    return np.array(rows)
