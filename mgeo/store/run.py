"""What a run is: everything that determines it, and what it found, as plain data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import ConfigDict, Field, Strict

from mgeo._typing import FloatArray
from mgeo.validation.tables import Table

Point = Annotated[tuple[float, ...], Strict(False)]  # of JSON, it is a list
Names = Annotated[tuple[str, ...], Strict(False)]  # of JSON, it is a list


class RunConfiguration(Table):
    """A run to be made, or made again: the same configuration gives the same front.

    Attributes
    ----------
    problem, algorithm
        Names, see `mgeo.plugins.discovery` and `mgeo.runs.algorithms`.
    options, parameters
        What they are built from, JSON values.
    evaluations
        The budget.
    seed
        Of all randomness.
    starts
        How many designs that the problem suggests the search begins with.
    polish
        Whether the problem refines what the search has found.
    """

    problem: str
    options: dict[str, Any]
    algorithm: str
    parameters: dict[str, Any]
    evaluations: int = Field(ge=1)
    seed: int = Field(ge=0)
    starts: int = Field(default=0, ge=0)
    polish: bool = False


class Hypervolume(Table):
    """A hypervolume with reference point (1, ..., 1), and the space it was measured in.

    ``space`` is "problem" (the problem's `indicator_space`) or "seen": objectives scaled so that
    everything the run evaluated lies between 0 (``ideal``) and 1 (``nadir``), in which case the
    value does not compare with that of another run.
    """

    value: float
    space: Literal["problem", "seen"]
    ideal: Point = ()
    nadir: Point = ()


@dataclass(frozen=True, eq=False)
class Nearest:
    """Solutions that violate constraints, the nearest first.

    Those come first that no other beats in every constraint, and of these the one with the least
    sum of violations. No two have the same objectives and violations.

    Attributes
    ----------
    X, F, violation : arrays, shapes (n, n_var), (n, n_obj) and (n, n_constraints)
        n is 0 for a run that found what keeps all constraints. A violation is at least 0, in what
        the constraint is computed in; inequalities first, then equalities beyond their tolerance.
    """

    X: FloatArray
    F: FloatArray
    violation: FloatArray

    @classmethod
    def none(cls) -> Nearest:
        return cls(*(np.empty((0, 0)) for _ in range(3)))

    def __len__(self) -> int:
        return len(self.X)


class Outcome(Table):
    """What a run found: its front, ordered by the first objective, and how it went.

    ``X`` is (n, n_var) and ``F`` is (n, n_obj), both in the problem's own units; n = 0 if no
    feasible solution was found. ``nearest`` is then what came nearest to the ``constraints``.
    ``started`` is UTC, ``wall_time_s`` in seconds. ``failures`` tells how many of the evaluations
    failed why, ``rough`` how many of the first gave no more than estimates (see `mgeo.MGEOStaged`).
    ``refined`` tells in how many places of the search's front a refinement has put something
    better, ``added`` how many it has put between them, ``unrefined`` why one that was asked for has
    come to no end.
    """

    model_config = ConfigDict(extra="ignore", arbitrary_types_allowed=True)

    status: Literal["finished", "interrupted"]
    evaluations: int
    failures: dict[str, int] = Field(default_factory=dict)
    rough: int = 0
    refined: int = 0
    added: int = 0
    unrefined: str = ""
    hypervolume: Hypervolume | None
    variables: Names
    objectives: Names
    constraints: Names = ()
    started: Annotated[datetime, Strict(False)]
    wall_time_s: float
    X: FloatArray = Field(default_factory=lambda: np.empty((0, 0)), exclude=True)
    F: FloatArray = Field(default_factory=lambda: np.empty((0, 0)), exclude=True)
    nearest: Nearest = Field(default_factory=Nearest.none, exclude=True)


class Notes(Table):
    """What a checkpoint of a run says besides the state of the algorithm.

    ``record`` tells whether every evaluation is recorded, ``seen`` the least and the greatest
    values of the objectives so far; it is empty before there are any. ``nearest`` holds rows of
    `mgeo.runs.meters.NearestMeter`, while nothing has kept all constraints. ``rough`` is that of
    `Outcome`.
    """

    configuration: RunConfiguration
    record: bool
    started: Annotated[datetime, Strict(False)]
    wall_time_s: float
    seen: list[list[float]]
    nearest: list[list[float]] = Field(default_factory=list)
    rough: int = Field(default=0, ge=0)


@dataclass(frozen=True, eq=False)
class Run:
    """A finished or interrupted run: how to make it again, what it found, what it ran with."""

    configuration: RunConfiguration
    outcome: Outcome
    versions: Mapping[str, str]
