"""Data of a run: its configuration, its outcome, and the versions of the software."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import ConfigDict, Field, Strict

from mgeo._typing import FloatArray
from mgeo.validation.tables import Table

Names = Annotated[tuple[str, ...], Strict(False)]  # JSON has lists, but no tuples.

#: Reasons for the end of a run: its budget of evaluations, ``--max-time``, a signal or a call of
#: `mgeo.runs.solve.SolveState.stop`, or no new designs from the algorithm.
StopReason = Literal["budget", "max_time", "signal", "exhausted"]

_END_DESCRIPTIONS: dict[StopReason, str] = {
    "budget": "finished",
    "max_time": "stopped by --max-time",
    "signal": "interrupted",
    "exhausted": "finished without a new design",
}


class RunConfiguration(Table):
    """All settings that determine the front of a run.

    Attributes
    ----------
    problem : str
        Name of the problem; see `mgeo.plugins.discovery`.
    options : dict
        Options of the problem as JSON values, such as the keys of a scenario.
    algorithm : str
        Name of the algorithm, as the command ``mgeo algorithms`` lists it.
    parameters : dict
        Parameters of the algorithm as JSON values.
    evaluations : int
        Budget of evaluations.
    seed : int
        Seed of all random numbers.
    initial_designs : int
        Number of initial designs suggested by the problem.
    refine : bool
        Whether the problem refines the front locally after the search.
    """

    problem: str
    options: dict[str, Any]
    algorithm: str
    parameters: dict[str, Any]
    evaluations: int = Field(ge=1)
    seed: int = Field(ge=0)
    initial_designs: int = Field(default=0, ge=0)
    refine: bool = False


@dataclass(frozen=True, eq=False)
class NearestSolutions:
    """Solutions closest to feasibility, for a run that found no feasible solution.

    The closest solution comes first.

    Attributes
    ----------
    X : array, shape (n, n_var)
        Variables; n is 0 for a run with a feasible solution.
    F : array, shape (n, n_obj)
        Objectives.
    violation : array, shape (n, n_constraints)
        Constraint violations, at least 0, in the units of the constraints: first inequalities, then
        equalities beyond their tolerance.
    """

    X: FloatArray
    F: FloatArray
    violation: FloatArray

    @classmethod
    def empty(cls) -> NearestSolutions:
        return cls(*(np.empty((0, 0)) for _ in range(3)))

    def __len__(self) -> int:
        return len(self.X)


def _empty_array() -> FloatArray:
    return np.empty((0, 0))


class Outcome(Table):
    """Result of a run: the front and the statistics of the run.

    The front is sorted by the first objective.

    Attributes
    ----------
    X, F, G, H : arrays, shapes (n, n_var), (n, n_obj), (n, n_ieq_constr) and (n, n_eq_constr)
        Variables, objectives, inequality and equality constraints, in units of the problem; n is 0
        if no feasible solution was found.
    variables : tuple of str
        Names of the variables, which are the columns of X.
    objectives : tuple of str
        Names of the objectives, which are the columns of F.
    constraints : tuple of str
        Names of the constraints.
    arrays : mapping of arrays, shape (n, ...)
        Further values of each solution, from ``View.arrays()`` of the problem.
    nearest : NearestSolutions
        Solutions nearest to feasibility if no solution is feasible.
    stop_reason : StopReason
        Reason for the end of the run.
    n_evaluations : int
        Number of evaluations.
    failures : dict of str to int
        Number of failed evaluations by cause.
    n_low_fidelity : int
        Number of initial low-fidelity evaluations (see `mgeo.MGEOStaged`).
    n_refined : int
        Number of solutions that the local refinement replaced.
    n_added : int
        Number of solutions that the local refinement added.
    refinement_error : str
        Reason for an early end of the local refinement, otherwise empty.
    checkpoint_error : str or None
        Error of the last checkpoint, None if it was written.
    hypervolume : float or None
        Hypervolume in the indicator space of the problem, None if the problem has none.
    start_time : datetime
        Start of the run (UTC).
    wall_time_s : float
        Duration of the run [s].
    """

    model_config = ConfigDict(extra="ignore", arbitrary_types_allowed=True)

    stop_reason: StopReason
    n_evaluations: int
    failures: dict[str, int] = Field(default_factory=dict)
    n_low_fidelity: int = 0
    n_refined: int = 0
    n_added: int = 0
    refinement_error: str = ""
    checkpoint_error: str | None = None
    hypervolume: float | None
    variables: Names
    objectives: Names
    constraints: Names = ()
    start_time: Annotated[datetime, Strict(False)]
    wall_time_s: float
    X: FloatArray = Field(default_factory=_empty_array, exclude=True)
    F: FloatArray = Field(default_factory=_empty_array, exclude=True)
    G: FloatArray = Field(default_factory=_empty_array, exclude=True)
    H: FloatArray = Field(default_factory=_empty_array, exclude=True)
    arrays: dict[str, NDArray[Any]] = Field(default_factory=dict, exclude=True)
    nearest: NearestSolutions = Field(default_factory=NearestSolutions.empty, exclude=True)

    @property
    def end_description(self) -> str:
        """Phrase that states how the run ended, such as "finished" or "interrupted"."""
        return _END_DESCRIPTIONS[self.stop_reason]


class CheckpointMetadata(Table):
    """Settings and statistics of a run that its checkpoint stores as metadata.

    Attributes
    ----------
    configuration : RunConfiguration
        All settings of the run.
    record : bool
        Whether every evaluation is recorded.
    start_time, wall_time_s, n_low_fidelity
        As in `Outcome`, up to the checkpoint.
    """

    configuration: RunConfiguration
    record: bool
    start_time: Annotated[datetime, Strict(False)]
    wall_time_s: float
    n_low_fidelity: int = Field(default=0, ge=0)


@dataclass(frozen=True, eq=False)
class Run:
    """Configuration, outcome and software versions of a finished or interrupted run."""

    configuration: RunConfiguration
    outcome: Outcome
    versions: Mapping[str, str]
