"""Base class of the published algorithms: independent walkers that move in lockstep."""

import math
from abc import ABC, abstractmethod
from typing import Any

import numpy as np
from pymoo.core.problem import Problem

from mgeo._typing import BoolArray, FloatArray, IntArray
from mgeo.algorithms.base import ExtremalOptimization
from mgeo.algorithms.selection import (
    INITIAL_TAU,
    RULES,
    compute_fitness,
    compute_next_tau,
    draw_position,
    find_best_fitness,
    is_better,
    rank,
)
from mgeo.validation.arguments import validate_choice, validate_integer, validate_number

RESTARTS = ("never", "random", "archive")


class IndependentWalkers(ExtremalOptimization, ABC):
    """Base class for extremal optimization in which the walkers search independently.

    Each candidate differs from its walker in one coordinate. In each generation, a walker draws an
    objective, ranks its candidates by this objective, and accepts one candidate per group. A
    subclass implements `build_encoding`, `build_layout` and `propose`, and sets
    `evaluates_walkers`.

    Walkers do not interact, except in restarts from the archive. Each walker has its own random
    stream (child i of the seed), so that parallel and sequential execution give the same result. A
    stream is used in this order: start; then in each generation the proposal, one uniform number
    for the objective, one per candidate to break ties, and one per group to select a rank; for an
    adaptive tau, a uniform and a normal number; and the restart. Random starting points are only
    evaluated if `evaluates_walkers` is true.

    Parameters
    ----------
    tau : selection pressure, >= 0; or "a-geo1" or "a-geo2" for a tau that adapts during the run.
    restart : "never", or the new start of a walker without progress: a "random" point, or a point
        of the "archive". Progress is a candidate that enters the archive or improves on the best
        value of the walker in any objective.
    patience : generations without progress before a restart.
    n_walkers, sampling, archive_size, options : as for `ExtremalOptimization`.
    """

    #: True to evaluate each walker before its candidates. Required with several groups, because the
    #: walker then combines several accepted candidates and has not been evaluated yet.
    evaluates_walkers = False

    #: Return value of `build_layout`.
    _coordinates: IntArray
    #: Index of the candidate at each entry of the layout, -1 for padding.
    _candidate_indices: IntArray
    #: Mask of the entries of the layout that are not padding.
    _is_candidate: BoolArray

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
    def build_layout(self) -> IntArray:
        """Return the groups of candidates that compete with each other, one row per group.

        Each entry is the index of the coordinate that a candidate changes. One candidate of each
        group is accepted.

        Returns
        -------
        array of int, shape (n_groups, group_size)
            Indices of coordinates. Shorter groups are padded with -1; no group may be empty.
        """

    @abstractmethod
    def propose(self) -> FloatArray:
        """Return the new value of the changed coordinate for every candidate.

        Returns
        -------
        array, shape (n_walkers, n_groups, group_size)
            Values in the order of `build_layout`; values at its padding are ignored.
        """

    def _initialize_run(self, problem: Problem) -> None:
        self._coordinates = self.build_layout()
        self._is_candidate = mask = self._coordinates >= 0
        self._candidate_indices = np.where(mask, np.cumsum(mask).reshape(mask.shape) - 1, -1)
        super()._initialize_run(problem)

    def reset_walkers(self, rows: IntArray) -> None:
        super().reset_walkers(rows)
        state = self.state
        state.taus[rows] = INITIAL_TAU
        state.improvement_chances[rows] = 1.0 / math.sqrt(len(self.variables.kinds))
        worst = np.inf, *np.zeros(state.taus.shape[1])  # Fitness of a failed evaluation.
        state.current_fitness[rows] = state.incumbent_fitness[rows] = worst

    def generate_candidates(self) -> FloatArray:
        self.proposals = self.propose()
        coordinates = self._coordinates[self._is_candidate]
        offset = int(self.evaluates_walkers)  # Row of the first candidate.
        points = np.repeat(self.walkers[:, None, :], offset + len(coordinates), axis=1)
        points[:, offset + np.arange(len(coordinates)), coordinates] = self.proposals[
            :, self._is_candidate
        ]
        decoded = self.encoding.decode(points)
        return decoded.reshape(-1, decoded.shape[-1])

    def accept(self, F: FloatArray, violation: FloatArray) -> BoolArray:
        F = F.reshape(self.n_walkers, -1, F.shape[1])
        violation = violation.reshape(self.n_walkers, -1)
        n_groups = len(self._candidate_indices)
        offset = int(self.evaluates_walkers)  # Row of the first candidate.
        n = F.shape[1] - offset
        draws = np.array([stream.random(1 + n + n_groups) for stream in self.streams])
        objective = (draws[:, 0] * F.shape[2]).astype(np.intp)
        improved = np.zeros(self.n_walkers, dtype=np.bool_)
        tau: Any = self.tau
        if needs_fitness := isinstance(self.tau, str) or self.restart != "never":
            values = compute_fitness(F, violation)
            if offset:
                self.state.current_fitness = values[:, 0].copy()
                improved = self._update_incumbent_fitness(values[:, :1])
            if isinstance(self.tau, str):
                tau = self._adapt_tau(objective, values[:, offset:])
            improved = improved | self._update_incumbent_fitness(values[:, offset:])
        f = np.take_along_axis(F, objective[:, None, None], axis=2)[:, offset:, 0]
        f[~np.isfinite(F[:, offset:]).all(axis=2)] = np.nan
        ties = self._arrange_by_group(draws[:, 1 : 1 + n], 2.0)  # The padding is ranked last.
        ranking = rank(
            self._arrange_by_group(f, np.nan),
            self._arrange_by_group(violation[:, offset:], 0.0),
            ties,
        )
        position = draw_position(
            draws[:, 1 + n :], np.count_nonzero(self._is_candidate, axis=1), tau
        )
        walker, group = np.arange(self.n_walkers)[:, None], np.arange(n_groups)[None, :]
        accepted = ranking[walker, group, position]
        coordinates = self._coordinates[group, accepted]
        self.walkers[walker, coordinates] = self.proposals[walker, group, accepted]
        if needs_fitness and n_groups == 1:
            rows = offset + self._candidate_indices[0, accepted[:, 0]]
            self.state.current_fitness = values[np.arange(self.n_walkers), rows]
        return improved

    def _arrange_by_group(self, values: FloatArray, padding: float) -> FloatArray:
        """Arrange values of all candidates in an array with one row per group of competitors.

        Shorter groups are filled with `padding`.
        """
        return np.where(self._is_candidate, values[:, self._candidate_indices], padding)

    def _adapt_tau(self, objective: IntArray, values: FloatArray) -> FloatArray:
        """Update the adaptive tau of each walker, and return the new values.

        `objective` is the index of the objective that ranks the candidates of each walker. `values`
        is the fitness of the candidates, shape (n_walkers, n, 1 + n_obj). The result has the shape
        (n_walkers, 1).
        """
        state = self.state
        is_a_geo1 = self.tau == "a-geo1"
        reference = state.incumbent_fitness if is_a_geo1 else state.current_fitness
        drawn = np.arange(self.n_walkers), objective
        chance = is_better(values, reference[:, None]).mean(axis=1)[drawn]
        uniform = np.array([stream.random() for stream in self.streams])
        normal = np.array([stream.standard_normal() for stream in self.streams])
        state.taus[drawn] = compute_next_tau(
            state.taus[drawn],
            chance,
            state.improvement_chances[drawn],
            normal,
            uniform,
            self.walkers.shape[1],
        )
        state.improvement_chances[drawn] = chance
        return state.taus[drawn][:, None]

    def _update_incumbent_fitness(self, values: FloatArray) -> BoolArray:
        """Update the best fitness of each walker, and return True for each improved walker.

        `values` is the fitness of n points per walker, shape (n_walkers, n, 1 + n_obj).
        """
        before = self.state.incumbent_fitness
        self.state.incumbent_fitness = find_best_fitness(
            np.concatenate([before[:, None], values], axis=1)
        )
        return np.asarray(is_better(self.state.incumbent_fitness, before).any(axis=1))

    def restart_idle_walkers(
        self, has_progress: BoolArray, has_archived_candidate: BoolArray
    ) -> None:
        if self.restart == "never":
            return
        self.state.n_idle_generations = np.where(
            has_progress | has_archived_candidate, 0, self.state.n_idle_generations + 1
        )
        rows = np.flatnonzero(self.state.n_idle_generations >= self.patience)
        if self.restart == "archive" and len(self.front) and len(rows):
            points = [self.streams[walker].integers(len(self.front)) for walker in rows]
            self.restart_walkers(rows, self.get_archived_points(points))
        elif len(rows):
            self.restart_walkers(rows)
