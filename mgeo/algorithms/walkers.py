"""Walkers of extremal optimization on arrays alone: what they try, and how they go on."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any

import numpy as np
from pymoo.core.problem import Problem

from mgeo._typing import BoolArray, FloatArray, IntArray
from mgeo.algorithms import adaptive
from mgeo.algorithms.acceptance import pick, rank
from mgeo.algorithms.run_state import RunState
from mgeo.algorithms.variables import Variables
from mgeo.pareto.archive import ParetoArchive


class Walkers(ABC):
    """Independent walkers in lockstep: the part of `ExtremalOptimization` without pymoo.

    The random stream of each walker gives, in this order: what the leaf draws to start; then for
    each generation what the leaf draws to propose, one uniform for the objective, one per
    candidate to break ties and one per group to pick a rank; with an adaptive tau a uniform and a
    normal; and what a restart draws.

    A leaf supplies `_variables`, `_draw`, `_layout`, `_propose`, `_decode` and `_encode`, and
    nothing else of the loop; one that carries more than `RunState` supplies `_new_state`, too.

    Attributes
    ----------
    state : the `RunState`: all that is carried from one generation to the next.
    front, streams, walkers : those of the state.
    """

    # Whether a walker is evaluated with its candidates, before them: for leaves with several
    # groups, where it is a combination of candidates that has not been evaluated yet.
    _evaluates_walkers = False

    tau: float | str
    n_walkers: int
    restart: str
    patience: int
    variables: Variables
    state: RunState
    _coordinates: IntArray
    _order: IntArray  # of `_layout`: which candidate each entry is
    _present: BoolArray | None  # of `_layout`: which entries are candidates; None if all are
    _sizes: int | IntArray  # of the groups
    _values: FloatArray  # what is proposed, until it is accepted

    # ---- what a leaf supplies -------------------------------------------------------------

    @abstractmethod
    def _variables(self, problem: Problem) -> Variables:
        """Check the problem's variables, and that the parameters fit them."""

    @abstractmethod
    def _draw(self, streams: Sequence[np.random.Generator]) -> FloatArray:
        """(n, n_coordinates) a random point from each of n streams."""

    @abstractmethod
    def _layout(self) -> IntArray:
        """(n_groups, group_size) coordinate each candidate changes; one a group is accepted.

        -1 where a group is shorter than the longest one; no group is empty.
        """

    @abstractmethod
    def _propose(self) -> FloatArray:
        """(n_walkers, n_groups, group_size) new values of the coordinates of `_layout`."""

    @abstractmethod
    def _decode(self, points: FloatArray) -> FloatArray:
        """(..., n_var) variables of points given by their (..., n_coordinates)."""

    @abstractmethod
    def _encode(self, values: FloatArray) -> FloatArray:
        """(..., n_coordinates) point nearest to given variables, (..., n_var)."""

    def _new_state(
        self, streams: list[np.random.Generator], front: ParetoArchive, walkers: FloatArray
    ) -> RunState:
        """The state to begin with; `_forget` fills in what is known of walkers."""
        return RunState.begin(streams, front, walkers)

    # ---- the loop ---------------------------------------------------------------------------

    @property
    def front(self) -> ParetoArchive:
        """The archive."""
        return self.state.front

    @property
    def streams(self) -> list[np.random.Generator]:
        """One random stream per walker."""
        return self.state.streams

    @property
    def walkers(self) -> FloatArray:
        """(n_walkers, n_coordinates) where the walkers stand."""
        return self.state.walkers

    def _place(
        self,
        streams: list[np.random.Generator],
        front: ParetoArchive,
        starts: FloatArray | None,
    ) -> None:
        """Begin at given variables, (n, n_var); walkers beyond n where the leaf draws."""
        self._coordinates = self._layout()
        present = self._coordinates >= 0
        sizes = np.count_nonzero(present, axis=1)
        self._order = np.where(present, np.cumsum(present).reshape(present.shape) - 1, -1)
        self._present = None if present.all() else present
        self._sizes = present.shape[1] if present.all() else sizes
        if starts is None:
            walkers = self._draw(streams)
        else:
            given = self._encode(starts)
            others = [self._draw(streams[len(given) :])] if len(given) < self.n_walkers else []
            walkers = np.concatenate([given, *others])
        self.state = self._new_state(streams, front, walkers)
        self._forget(np.arange(self.n_walkers))

    def _forget(self, rows: IntArray) -> None:
        """Let walkers begin: all but where they stand is as of a new one."""
        state = self.state
        state.taus[rows] = adaptive.START
        state.chances[rows] = adaptive.first_chance(len(self.variables.kinds))
        state.standing[rows] = state.best[rows] = adaptive.unknown(state.taus.shape[1])
        state.idle[rows] = 0

    def _candidates(self) -> FloatArray:
        """(n_walkers * candidates a walker, n_var) variables to evaluate, walker by walker."""
        self._values = self._propose()
        present = ... if self._present is None else self._present
        changed = self._coordinates[present].ravel()
        own = int(self._evaluates_walkers)
        points = np.repeat(self.walkers[:, None, :], own + len(changed), axis=1)
        values = self._values[:, present].reshape(self.n_walkers, -1)
        points[:, own + np.arange(len(changed)), changed] = values
        decoded = self._decode(points)
        return decoded.reshape(-1, decoded.shape[-1])

    def _accept(self, F: FloatArray, violation: FloatArray) -> BoolArray:
        """Move the walkers by what their candidates are worth.

        Parameters
        ----------
        F : (n, n_obj) objectives of `_candidates`.
        violation : (n,) constraint violations, 0 where feasible.

        Returns
        -------
        (n_walkers,) mask of the walkers that bettered their own best in some objective; all False
        if that is not kept.
        """
        F, violation = (
            F.reshape(self.n_walkers, -1, F.shape[1]),
            violation.reshape(self.n_walkers, -1),
        )
        groups = len(self._order)
        own = int(self._evaluates_walkers)
        n = F.shape[1] - own
        draws = np.array([stream.random(1 + n + groups) for stream in self.streams])
        objective = (draws[:, 0] * F.shape[2]).astype(np.intp)
        improved = np.zeros(self.n_walkers, dtype=np.bool_)
        tau: Any = self.tau
        if watched := isinstance(self.tau, str) or self.restart != "never":
            merit = adaptive.merits(F, violation)
            if own:
                self.state.standing = merit[:, 0].copy()
                improved = self._remember(merit[:, :1])
            if isinstance(self.tau, str):
                tau = self._adapted(objective, merit[:, own:])
            improved = improved | self._remember(merit[:, own:])
        f = np.take_along_axis(F, objective[:, None, None], axis=2)[:, own:, 0]
        f[~np.isfinite(F[:, own:]).all(axis=2)] = np.nan
        ties = self._grouped(draws[:, 1 : 1 + n], 2.0)  # what is absent comes last
        ranking = rank(self._grouped(f, np.nan), self._grouped(violation[:, own:], 0.0), ties)
        place = pick(draws[:, 1 + n :], self._sizes, tau)
        walker, group = np.arange(self.n_walkers)[:, None], np.arange(groups)[None, :]
        accepted = ranking[walker, group, place]
        changed = self._coordinates[group, accepted]
        self.walkers[walker, changed] = self._values[walker, group, accepted]
        if watched and groups == 1:
            self.state.standing = merit[
                np.arange(self.n_walkers), own + self._order[0, accepted[:, 0]]
            ]
        return improved

    def _grouped(self, values: FloatArray, absent: float) -> FloatArray:
        """(n_walkers, n_groups, group_size) of values of the candidates, (n_walkers, n)."""
        if self._present is None:
            return values.reshape(self.n_walkers, *self._order.shape)
        return np.where(self._present, values[:, self._order], absent)

    def _adapted(self, objective: IntArray, merit: FloatArray) -> FloatArray:
        """(n_walkers, 1) greediness by the rule, renewed."""
        state = self.state
        reference = state.best if self.tau == "a-geo1" else state.standing
        drawn = np.arange(self.n_walkers), objective
        chance = adaptive.better(merit, reference[:, None]).mean(axis=1)[drawn]
        uniform = np.array([stream.random() for stream in self.streams])
        normal = np.array([stream.standard_normal() for stream in self.streams])
        state.taus[drawn] = adaptive.next_tau(
            state.taus[drawn], chance, state.chances[drawn], normal, uniform, self.walkers.shape[1]
        )
        state.chances[drawn] = chance
        return state.taus[drawn][:, None]

    def _remember(self, merit: FloatArray) -> BoolArray:
        """Keep the best of (n_walkers, n, 1 + n_obj) merits; tells who bettered it."""
        before = self.state.best
        self.state.best = adaptive.best(np.concatenate([before[:, None], merit], axis=1))
        return np.asarray(adaptive.better(self.state.best, before).any(axis=1))

    def _stuck(self, progress: BoolArray) -> IntArray:
        """The walkers without progress for `patience` generations."""
        self.state.idle = np.where(progress, 0, self.state.idle + 1)
        return np.flatnonzero(self.state.idle >= self.patience)

    def _begin_anew(self, rows: IntArray, starts: FloatArray | None) -> None:
        """Restart some walkers at given variables, (n, n_var), or where the leaf draws."""
        streams = [self.streams[walker] for walker in rows]
        self.walkers[rows] = self._draw(streams) if starts is None else self._encode(starts)
        self._forget(rows)
