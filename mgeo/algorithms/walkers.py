"""Independent walkers in lockstep: the loop of the published algorithms."""

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
    """Extremal optimization by walkers that change coordinate by coordinate.

    Every candidate differs from its walker in a single coordinate. A walker draws an objective,
    ranks its candidates by it, and accepts one; or one of each group, if there are several. A
    subclass supplies `representation`, `layout` and `propose`, and says by `evaluates_walkers`
    whether a walker is evaluated with its candidates.

    Unless it restarts, a walker never looks at the archive or at other walkers, and it owns a
    random stream (child i of the seed), so running side by side is the same as running one after
    the other. The stream gives, in this order: what is drawn to start; then for each generation
    what is drawn to propose, one uniform for the objective, one per candidate to break ties and
    one per group to pick a rank; with an adaptive tau a uniform and a normal; and what a restart
    draws. Random starting points are not evaluated, unless walkers are.

    Parameters
    ----------
    tau : selection pressure, >= 0; or a rule of `mgeo.algorithms.selection`.
    restart : "never", or where a walker without progress restarts: at a "random" point, or at one
        of the "archive". Progress is a candidate that enters the archive, or betters the walker's
        own best in some objective.
    patience : generations without progress before a restart.
    n_walkers, sampling, archive_size, options : as for `ExtremalOptimization`.
    """

    # Whether a walker is evaluated with its candidates, before them: where there are several
    # groups, it is a combination of candidates that has not been evaluated yet.
    evaluates_walkers = False

    _coordinates: IntArray
    _order: IntArray  # of `layout`: which candidate each entry is
    _present: BoolArray  # of `layout`: which entries are candidates

    def __init__(
        self,
        *,
        tau: float | str,
        n_walkers: int,
        restart: str = "never",
        patience: int = 50,
        **options: Any,
    ) -> None:
        adaptive = isinstance(tau, str)
        checked = (
            validate_choice("tau", tau, RULES) if adaptive else validate_number("tau", tau, low=0)
        )
        super().__init__(tau=checked, n_walkers=n_walkers, **options)
        self.restart = validate_choice("restart", restart, RESTARTS)
        self.patience = validate_integer("patience", patience, low=1)

    @abstractmethod
    def layout(self) -> IntArray:
        """(n_groups, group_size) coordinate each candidate changes; one a group is accepted.

        -1 where a group is shorter than the longest one; no group is empty.
        """

    @abstractmethod
    def propose(self) -> FloatArray:
        """(n_walkers, n_groups, group_size) new values of the coordinates of `layout`."""

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
        unknown = np.inf, *np.zeros(state.taus.shape[1])  # as if the evaluation had failed
        state.current_fitness[rows] = state.incumbent_fitness[rows] = unknown

    def candidates(self) -> FloatArray:
        self.proposed = self.propose()
        changed = self._coordinates[self._present]
        own = int(self.evaluates_walkers)
        points = np.repeat(self.walkers[:, None, :], own + len(changed), axis=1)
        points[:, own + np.arange(len(changed)), changed] = self.proposed[:, self._present]
        decoded = self.code.decode(points)
        return decoded.reshape(-1, decoded.shape[-1])

    def accept(self, F: FloatArray, violation: FloatArray) -> BoolArray:
        F = F.reshape(self.n_walkers, -1, F.shape[1])
        violation = violation.reshape(self.n_walkers, -1)
        groups = len(self._order)
        own = int(self.evaluates_walkers)
        n = F.shape[1] - own
        draws = np.array([stream.random(1 + n + groups) for stream in self.streams])
        objective = (draws[:, 0] * F.shape[2]).astype(np.intp)
        improved = np.zeros(self.n_walkers, dtype=np.bool_)
        tau: Any = self.tau
        if watched := isinstance(self.tau, str) or self.restart != "never":
            values = fitness(F, violation)
            if own:
                self.state.current_fitness = values[:, 0].copy()
                improved = self._improve(values[:, :1])
            if isinstance(self.tau, str):
                tau = self._adapt_tau(objective, values[:, own:])
            improved = improved | self._improve(values[:, own:])
        f = np.take_along_axis(F, objective[:, None, None], axis=2)[:, own:, 0]
        f[~np.isfinite(F[:, own:]).all(axis=2)] = np.nan
        ties = self._grouped(draws[:, 1 : 1 + n], 2.0)  # what is absent comes last
        ranking = rank(self._grouped(f, np.nan), self._grouped(violation[:, own:], 0.0), ties)
        place = pick(draws[:, 1 + n :], np.count_nonzero(self._present, axis=1), tau)
        walker, group = np.arange(self.n_walkers)[:, None], np.arange(groups)[None, :]
        accepted = ranking[walker, group, place]
        changed = self._coordinates[group, accepted]
        self.walkers[walker, changed] = self.proposed[walker, group, accepted]
        if watched and groups == 1:
            chosen = own + self._order[0, accepted[:, 0]]
            self.state.current_fitness = values[np.arange(self.n_walkers), chosen]
        return improved

    def _grouped(self, values: FloatArray, absent: float) -> FloatArray:
        """(n_walkers, n_groups, group_size) of values of the candidates, (n_walkers, n)."""
        return np.where(self._present, values[:, self._order], absent)

    def _adapt_tau(self, objective: IntArray, values: FloatArray) -> FloatArray:
        """(n_walkers, 1) selection pressure of the objectives drawn, after the rule."""
        state = self.state
        a_geo1 = self.tau == "a-geo1"
        reference = state.incumbent_fitness if a_geo1 else state.current_fitness
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
        """Keep the best of (n_walkers, n, 1 + n_obj) fitness; tells who bettered it."""
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
