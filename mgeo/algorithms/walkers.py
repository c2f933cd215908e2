"""Base class of the published algorithms: independent walkers that move in lockstep."""

import math
from abc import ABC, abstractmethod
from typing import Any

import numpy as np
from pymoo.core.problem import Problem

from mgeo._typing import BoolArray, FloatArray, IntArray
from mgeo.algorithms.base import ExtremalOptimization
from mgeo.algorithms.selection import RULES, START_TAU, best, better, fitness, next_tau, pick, rank
from mgeo.validation.arguments import validate_choice, validate_integer, validate_number

RESTARTS = ("never", "random", "archive")


class IndependentWalkers(ExtremalOptimization, ABC):
    """Extremal optimization with independent walkers that change single coordinates.

    Each candidate differs from its walker in one coordinate. In each generation, a walker draws an
    objective, ranks its candidates by this objective, and accepts one candidate per group. A
    subclass implements `representation`, `layout` and `propose`, and sets `evaluates_walkers`.

    Walkers do not interact, except in restarts from the archive. Each walker has its own random
    stream (child i of the seed), so that parallel and sequential execution give the same result. A
    stream is used in this order: start; then in each generation the proposal, one uniform number
    for the objective, one per candidate to break ties, and one per group to select a rank; for an
    adaptive tau, a uniform and a normal number; and the restart. Random starting points are only
    evaluated if `evaluates_walkers` is true.

    Parameters
    ----------
    tau : selection pressure, >= 0; or the name of a rule of `mgeo.algorithms.selection`.
    restart : "never", or the point at which a walker without progress restarts: "random", or a
        point of the "archive". Progress is a candidate that enters the archive or improves on the
        best value of the walker in any objective.
    patience : generations without progress before a restart.
    n_walkers, sampling, archive_size, options : as for `ExtremalOptimization`.
    """

    #: True to evaluate each walker before its candidates. Required with several groups, because the
    #: walker then combines several accepted candidates and has not been evaluated yet.
    evaluates_walkers = False

    _coordinates: IntArray  # Return value of `layout`.
    _order: IntArray  # Index of the candidate at each entry of `layout`, -1 for padding.
    _present: BoolArray  # Mask of the entries of `layout` that are not padding.

    def __init__(
        self,
        *,
        tau: float | str,
        n_walkers: int,
        restart: str = "never",
        patience: int = 50,
        **options: Any,
    ) -> None:
        is_adaptive = isinstance(tau, str)
        checked = (
            validate_choice("tau", tau, RULES)
            if is_adaptive
            else validate_number("tau", tau, low=0)
        )
        super().__init__(tau=checked, n_walkers=n_walkers, **options)
        self.restart = validate_choice("restart", restart, RESTARTS)
        self.patience = validate_integer("patience", patience, low=1)

    @abstractmethod
    def layout(self) -> IntArray:
        """Return the coordinate that each candidate changes, shape (n_groups, group_size).

        One candidate of each group is accepted. Shorter groups are padded with -1; no group may be
        empty.
        """

    @abstractmethod
    def propose(self) -> FloatArray:
        """Return new values of the coordinates, shape (n_walkers, n_groups, group_size).

        Values at the padding of `layout` are ignored.
        """

    def _begin(self, problem: Problem) -> None:
        self._coordinates = self.layout()
        self._present = present = self._coordinates >= 0
        self._order = np.where(present, np.cumsum(present).reshape(present.shape) - 1, -1)
        super()._begin(problem)

    def forget(self, rows: IntArray) -> None:
        super().forget(rows)
        state = self.state
        state.taus[rows] = START_TAU
        state.chances[rows] = 1.0 / math.sqrt(len(self.variables.kinds))
        worst = np.inf, *np.zeros(state.taus.shape[1])  # Fitness of a failed evaluation.
        state.current_fitness[rows] = state.incumbent_fitness[rows] = worst

    def candidates(self) -> FloatArray:
        self.proposed = self.propose()
        coordinates = self._coordinates[self._present]
        offset = int(self.evaluates_walkers)  # Row of the first candidate.
        points = np.repeat(self.walkers[:, None, :], offset + len(coordinates), axis=1)
        points[:, offset + np.arange(len(coordinates)), coordinates] = self.proposed[
            :, self._present
        ]
        decoded = self.code.decode(points)
        return decoded.reshape(-1, decoded.shape[-1])

    def accept(self, F: FloatArray, violation: FloatArray) -> BoolArray:
        F = F.reshape(self.n_walkers, -1, F.shape[1])
        violation = violation.reshape(self.n_walkers, -1)
        n_groups = len(self._order)
        offset = int(self.evaluates_walkers)  # Row of the first candidate.
        n = F.shape[1] - offset
        draws = np.array([stream.random(1 + n + n_groups) for stream in self.streams])
        objective = (draws[:, 0] * F.shape[2]).astype(np.intp)
        improved = np.zeros(self.n_walkers, dtype=np.bool_)
        tau: Any = self.tau
        if needs_fitness := isinstance(self.tau, str) or self.restart != "never":
            values = fitness(F, violation)
            if offset:
                self.state.current_fitness = values[:, 0].copy()
                improved = self._improve(values[:, :1])
            if isinstance(self.tau, str):
                tau = self._adapt_tau(objective, values[:, offset:])
            improved = improved | self._improve(values[:, offset:])
        f = np.take_along_axis(F, objective[:, None, None], axis=2)[:, offset:, 0]
        f[~np.isfinite(F[:, offset:]).all(axis=2)] = np.nan
        ties = self._group(draws[:, 1 : 1 + n], 2.0)  # Padding ranks last.
        ranking = rank(self._group(f, np.nan), self._group(violation[:, offset:], 0.0), ties)
        position = pick(draws[:, 1 + n :], np.count_nonzero(self._present, axis=1), tau)
        walker, group = np.arange(self.n_walkers)[:, None], np.arange(n_groups)[None, :]
        accepted = ranking[walker, group, position]
        coordinates = self._coordinates[group, accepted]
        self.walkers[walker, coordinates] = self.proposed[walker, group, accepted]
        if needs_fitness and n_groups == 1:
            rows = offset + self._order[0, accepted[:, 0]]
            self.state.current_fitness = values[np.arange(self.n_walkers), rows]
        return improved

    def _group(self, values: FloatArray, padding: float) -> FloatArray:
        """Arrange values of candidates, (n_walkers, n), as (n_walkers, n_groups, group_size)."""
        return np.where(self._present, values[:, self._order], padding)

    def _adapt_tau(self, objective: IntArray, values: FloatArray) -> FloatArray:
        """Update tau of the drawn objectives by the rule and return it, shape (n_walkers, 1)."""
        state = self.state
        is_a_geo1 = self.tau == "a-geo1"
        reference = state.incumbent_fitness if is_a_geo1 else state.current_fitness
        drawn = np.arange(self.n_walkers), objective
        chance = better(values, reference[:, None]).mean(axis=1)[drawn]
        uniform = np.array([stream.random() for stream in self.streams])
        normal = np.array([stream.standard_normal() for stream in self.streams])
        state.taus[drawn] = next_tau(
            state.taus[drawn], chance, state.chances[drawn], normal, uniform, self.walkers.shape[1]
        )
        state.chances[drawn] = chance
        return state.taus[drawn][:, None]

    def _improve(self, values: FloatArray) -> BoolArray:
        """Update the best fitness of each walker and return the mask of walkers that improved.

        `values` has the shape (n_walkers, n, 1 + n_obj).
        """
        before = self.state.incumbent_fitness
        self.state.incumbent_fitness = best(np.concatenate([before[:, None], values], axis=1))
        return np.asarray(better(self.state.incumbent_fitness, before).any(axis=1))

    def restart_idle(self, progress: BoolArray, entered: BoolArray) -> None:
        if self.restart == "never":
            return
        self.state.idle = np.where(progress | entered, 0, self.state.idle + 1)
        rows = np.flatnonzero(self.state.idle >= self.patience)
        if self.restart == "archive" and len(self.front) and len(rows):
            points = [self.streams[walker].integers(len(self.front)) for walker in rows]
            self.restart_walkers(rows, self.archived(points))
        elif len(rows):
            self.restart_walkers(rows)
