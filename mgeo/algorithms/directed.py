"""MGEODirected: walkers that head each for its own part of the front, and learn from the others."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from pymoo.core.problem import Problem
from pymoo.core.sampling import Sampling

from mgeo._typing import BoolArray, FloatArray, IntArray
from mgeo._validation import validate_fraction, validate_integer, validate_number, validate_pair
from mgeo.algorithms.acceptance import pick, rank
from mgeo.algorithms.base import ExtremalOptimization
from mgeo.algorithms.directed_state import DirectedState
from mgeo.algorithms.directions import distance, drawn, extent, fan
from mgeo.algorithms.joint_steps import joint_steps
from mgeo.algorithms.variables import Variables
from mgeo.pareto.archive import ParetoArchive

Extent = tuple[FloatArray, FloatArray]  # of the front: what `extent` gives

_PROGRESS = 1e-3  # of the front's extent: what a walker's best must come nearer by, to count


class MGEODirected(ExtremalOptimization):
    """Extremal optimization of real variables by walkers with directions, memory and company.

    As in MGEO_real, every variable of a walker gives one candidate, the candidates are ranked,
    and one is accepted with a probability proportional to k^-tau, be it better or not. Different
    are what they are ranked by, how a candidate is made, and that a walker may go back:

    - A walker has a direction of the objective space and ranks by the distance along it
      (weighted Tchebycheff, scaled by the front that the run has found so far) in place of an
      objective drawn at random. Some walkers head for the ends of the front, that is for one
      objective alone; the others are spread evenly between the ends, at first.
    - A candidate changes its variable, and others with some probability: either by normal steps,
      as wide as the bounds down to a thousandth of that, or by a fraction of the difference
      between two points of the company (differential evolution's move; Storn & Price 1997).
      The company are the points of the archive and the best points of the walkers.
    - A walker now and then goes back to its own best point, and more rarely to the archived
      point that is nearest to its direction.
    - A walker that gets no further begins anew: at a random point if it heads for an end, where
      local optima are many; otherwise in another direction, from the archive's nearest point.

    Walkers are therefore not independent: a walker's path depends on the others. All numbers but
    random points to begin at come from the algorithm's one random stream. A generation costs
    n_walkers x min(n_var, max_candidates) evaluations; nothing depends on the termination. With one
    objective all walkers minimize it.

    Parameters
    ----------
    tau : greediness, >= 0: the candidate of rank k is accepted with probability ~ k^-tau.
    n_walkers : number of walkers.
    ends : share of the walkers that head for an end of the front, in [0, 1].
    difference : share of the candidates made by differences, in [0, 1].
    coupling : mean probabilities that a candidate changes also each of the other variables: made
        by normal steps, and made by differences. Each candidate draws its own (`joint_steps`).
    widths : smallest and largest standard deviation of normal steps, as a fraction of the width
        of the bounds; each candidate's is log-uniform between them.
    recall : probability a generation that a walker goes back to its own best point.
    adopt : probabilities a generation that a walker goes to the archive's nearest point instead:
        of those between the ends, and of those that head for an end. The latter had better be
        rare: an end may have many local optima, and each walker its own.
    renew : numbers of generations without progress after which a walker begins anew, >= 1: of
        those between the ends, and of those that head for an end.
    max_candidates : largest number of candidates of a walker; with more variables than that, so
        many of them are drawn at random each generation.
    sampling : points at which the first walkers start: up to (n_walkers, n_var), population or
        pymoo `Sampling`; the others begin uniform within the bounds. Starting points are not
        evaluated themselves.
    archive_size : largest number of points in the front, None for all of them.
    options : options of every pymoo algorithm: `termination` (5000 // n_walkers generations unless
        given), `callback`, `output`, `verbose`, `seed`, `save_history`, ...

    Attributes
    ----------
    state : the `DirectedState`.

    Raises
    ------
    TypeError, ValueError : for a parameter of the wrong type or out of range, or an unknown one.
    """

    state: DirectedState

    def __init__(
        self,
        tau: float = 3.0,
        n_walkers: int = 8,
        ends: float = 0.4,
        difference: float = 0.5,
        coupling: Sequence[float] = (0.25, 0.5),
        widths: Sequence[float] = (1e-3, 1.0),
        recall: float = 0.3,
        adopt: Sequence[float] = (0.2, 0.02),
        renew: Sequence[int] = (4, 50),
        max_candidates: int = 12,
        *,
        sampling: Sampling | ArrayLike | None = None,
        archive_size: int | None = None,
        **options: Any,
    ) -> None:
        super().__init__(
            tau=validate_number("tau", tau, low=0),
            n_walkers=n_walkers,
            sampling=sampling,
            archive_size=archive_size,
            options=options,
        )
        self.ends = validate_fraction("ends", ends)
        self.difference = validate_fraction("difference", difference)
        self.coupling = validate_pair("coupling", coupling, validate_fraction)
        self.widths = validate_pair("widths", widths, validate_number, above=0)
        if self.widths[0] > self.widths[1]:
            raise ValueError(f"widths = {widths!r}: expected the smaller one first")
        self.recall = validate_fraction("recall", recall)
        self.adopt = validate_pair("adopt", adopt, validate_fraction)
        if self.recall + max(self.adopt) > 1:
            raise ValueError(f"recall = {recall!r}, adopt = {adopt!r}: expected sums of at most 1")
        self.renew = validate_pair("renew", renew, validate_integer, low=1)
        self.max_candidates = validate_integer("max_candidates", max_candidates, low=1)

    def _variables(self, problem: Problem) -> Variables:
        return Variables.of(problem, ["real"])

    def _draw(self, streams: Sequence[np.random.Generator]) -> FloatArray:
        xl, xu = self.variables.xl, self.variables.xu
        unit = np.stack([stream.random(len(xl)) for stream in streams])
        starts: FloatArray = np.clip(xl + (xu - xl) * unit, xl, xu)
        return starts

    def _new_state(
        self, streams: list[np.random.Generator], front: ParetoArchive, walkers: FloatArray
    ) -> DirectedState:
        n, n_obj = len(walkers), front.F.shape[1]
        return DirectedState.begin(
            streams,
            front,
            walkers,
            directions=fan(n, n_obj, self.ends),
            memory=np.empty_like(walkers),
            memory_F=np.empty((n, n_obj)),
            memory_violation=np.empty(n),
            marked_F=np.empty((n, n_obj)),
        )

    def _forget(self, rows: IntArray) -> None:
        super()._forget(rows)
        state = self.state
        state.memory[rows] = state.walkers[rows]
        state.memory_F[rows] = state.marked_F[rows] = np.inf
        state.memory_violation[rows] = np.inf

    def _layout(self) -> IntArray:
        return np.arange(len(self.variables.kinds), dtype=np.intp)[None, :]

    def _propose(self) -> FloatArray:
        """(n_walkers, n_candidates, n_var) whole points, each of which changes its own variable."""
        xl, xu = self.variables.xl, self.variables.xu
        own = np.broadcast_to(np.arange(len(xl)), (self.n_walkers, len(xl)))
        if len(xl) > self.max_candidates:
            own = self.random_state.permuted(own, axis=1)[:, : self.max_candidates]
        differences = self._differences if len(self.front) else None
        steps = joint_steps(
            own, xu - xl, self.widths, self.coupling, self.difference, differences,
            self.random_state,
        )  # fmt: skip
        return np.asarray(np.clip(self.walkers[:, None, :] + steps, xl, xu))

    def _differences(self, shape: tuple[int, ...]) -> FloatArray:
        """(..., n_var) differences of two points, each from the archive or a walker's memory."""
        rng, n = self.random_state, len(self.front)
        draws = [
            (
                rng.integers(n, size=shape),
                rng.integers(self.n_walkers, size=shape),
                rng.random(shape),
            )
            for _ in range(2)
        ]
        archived, remembered, coin = (np.stack(each) for each in zip(*draws, strict=True))
        known = self.variables.values(self.front.individuals[archived.ravel()].get("X"))
        first, second = np.where(
            coin[..., None] < 0.5, known.reshape(*coin.shape, -1), self.state.memory[remembered]
        )
        return np.asarray(first - second)

    def _candidates(self) -> FloatArray:
        self._values = self._propose()
        return self._values.reshape(-1, self._values.shape[-1])

    def _accept(self, F: FloatArray, violation: FloatArray) -> BoolArray:
        state = self.state
        F = F.reshape(self.n_walkers, -1, F.shape[1])
        violation = np.where(np.isfinite(F).all(axis=2), violation.reshape(F.shape[:2]), np.inf)
        known = extent(state.front.F)
        merit = distance(F, state.directions[:, None], *known)
        rng, n = self.random_state, F.shape[1]
        ranking = rank(merit, violation, rng.random(merit.shape))
        accepted = ranking[
            np.arange(self.n_walkers), pick(rng.random(self.n_walkers), n, float(self.tau))
        ]
        less = self._remember_best(F, violation, merit, ranking[:, 0], known)
        state.walkers = self._values[np.arange(self.n_walkers), accepted]
        self._go_back(known)
        self._renew(less, known)
        return np.zeros(self.n_walkers, dtype=np.bool_)

    def _remember_best(
        self,
        F: FloatArray,
        violation: FloatArray,
        merit: FloatArray,
        best: IntArray,
        known: Extent,
    ) -> BoolArray:
        """Keep the best points; tells whose constraint violation is less than ever."""
        state, one = self.state, (np.arange(self.n_walkers), best)
        before = distance(state.memory_F, state.directions, *known)
        less = violation[one] < state.memory_violation
        better = less | (
            (violation[one] == 0) & (state.memory_violation == 0) & (merit[one] < before)
        )
        rows = np.flatnonzero(better)
        state.memory[rows] = self._values[one][rows]
        state.memory_F[rows] = F[one][rows]
        state.memory_violation[rows] = violation[one][rows]
        return np.asarray(less)

    def _go_back(self, known: Extent) -> None:
        state, chance = self.state, self.random_state.random(self.n_walkers)
        recalls = (chance < self.recall) & np.isfinite(state.memory_violation)
        state.walkers[recalls] = state.memory[recalls]
        adopt = np.where(self._between(), *self.adopt)
        adopts = np.flatnonzero((chance >= self.recall) & (chance < self.recall + adopt))
        if len(adopts) and len(state.front):
            self._go_to_front(adopts, known)

    def _go_to_front(self, rows: IntArray, known: Extent) -> None:
        """Put walkers on the archive's points nearest to their directions."""
        state, front = self.state, self.state.front
        nearest = distance(front.F, state.directions[rows][:, None], *known).argmin(axis=1)
        points = self.variables.values(front.individuals[nearest].get("X"))
        state.walkers[rows] = state.memory[rows] = points
        state.memory_F[rows] = front.F[nearest]
        state.memory_violation[rows] = front.violation

    def _renew(self, less: BoolArray, known: Extent) -> None:
        """Count who gets no further; let those begin anew who did not for long enough."""
        state = self.state
        far, before = (
            distance(F, state.directions, *known) for F in (state.memory_F, state.marked_F)
        )
        feasible = state.memory_violation == 0
        ideal, nadir = known
        least = _PROGRESS if (ideal < nadir).all() else 0.0  # one objective has no extent
        nearer = feasible & ~(far >= before - least)  # true where nothing is marked yet
        state.marked_F[nearer] = state.memory_F[nearer]
        state.idle = np.where(nearer | less, 0, state.idle + 1)
        between = self._between()
        stuck = state.idle >= np.where(between, *self.renew)
        if len(rows := np.flatnonzero(stuck & between)) and len(state.front):
            state.directions[rows] = drawn(len(rows), state.directions.shape[1], self.random_state)
            self._go_to_front(rows, known)
            state.marked_F[rows] = state.memory_F[rows]
            state.idle[rows] = 0
        if len(rows := np.flatnonzero(stuck & ~between)):
            self._begin_anew(rows, None)

    def _between(self) -> BoolArray:
        """(n_walkers,) which walkers head for several objectives at once."""
        return np.asarray(self.state.directions.max(axis=1) < 1)

    def _decode(self, points: FloatArray) -> FloatArray:
        return points

    def _encode(self, values: FloatArray) -> FloatArray:
        return values
