"""MGEODirected: walkers that head each for its own part of the front, and learn from the others."""

from collections.abc import Sequence
from typing import Any, ClassVar

import numpy as np

from mgeo._typing import BoolArray, FloatArray, IntArray
from mgeo.algorithms.moves import DirectedMoves, Pair
from mgeo.algorithms.selection import draw_position, draw_weights, rank, tchebycheff_distance
from mgeo.algorithms.steps import AUTO, BOUNDS
from mgeo.validation.arguments import (
    validate_choice,
    validate_fraction,
    validate_integer,
    validate_number,
    validate_pair,
)

_PROGRESS_FACTOR = 0.1  # over the points of the front: the share of its extent that is progress
_SIGMA_LIMITS = 1e-6, 10.0  # widths of a distribution, of the bounds', between which it goes on


class MGEODirected(DirectedMoves):
    """Extremal optimization by walkers that head each for its own part of the front.

    As in MGEO_real, a walker tries a change of each of some variables, ranks what comes out, and
    accepts the change of rank k with a probability proportional to k^-tau, be it better or not.
    Four things are different:

    - **A goal of its own.** A walker ranks by the distance along its weight vector (weighted
      Tchebycheff, scaled by the front found so far). A share of them has extreme weights, of one
      objective alone; the others are spread between these extremes.
    - **Four kinds of candidates.** Recombination crosses two good points variable by variable, and
      mutates one variable on average (genetic algorithms; Deb & Agrawal 1995); its share of the
      candidates follows its gains (`mgeo.algorithms.recombination`). Momentum repeats part of the
      step that led to the walker's best point, and adds part of the way to an archived point, in
      all variables (particle swarms; Zhang et al. 2018). A difference is a fraction of the vector
      between two points of the archive or bests of walkers, in many variables (differential
      evolution; Storn & Price 1997). A normal step changes mostly one variable.
    - **Return.** After most generations a walker goes back to its best point, or, more rarely, to
      the archive's nearest along its weight vector.
    - **Restart.** Without progress it begins anew: with other weights, or, where it minimizes one
      objective alone and local optima are many, at a random point.

    In long runs, after 2,000 evaluations per variable, half of the walkers make their candidates by
    a normal distribution of their own, whose covariance they learn (`mgeo.algorithms.steps`).

    Variables are real, or, with `Problem(vars=...)`, integers, bits and choices beside them: steps
    are rounded then, and a choice takes the option of a donor (`mgeo.algorithms.steps`). A
    generation costs n_walkers x min(n_var, max_candidates) evaluations; nothing depends on the
    termination. With one objective all walkers minimize it.

    Parameters
    ----------
    tau : selection pressure, >= 0.
    n_walkers : number of walkers.
    extreme_weights : share of the walkers that minimize one objective alone, in [0, 1].
    difference : shares of the candidates made by differences, of those without momentum or
        recombination, in [0, 1]. Of this pair and others, the first is for walkers between the
        extremes, the second for those at them.
    momentum : shares of the candidates with momentum, of those without recombination, in [0, 1]
        (`draw_momentum_steps`); at the extremes only where the point that they are drawn to is within
        a step.
    max_candidates : largest number of candidates a walker; of more variables they are drawn.
    bounds : treatment of a step that leaves them: "clip" to the bound, "reflect" from it, or
        "resample", drawn anew until it stays inside (`mgeo.algorithms.steps`). "auto" reflects
        where the problem has equality constraints, and clips elsewhere.
    options : `sampling` and `archive_size` of `mgeo.algorithms.base.ExtremalOptimization`, and
        those of every pymoo algorithm: `termination` (5000 // n_walkers generations unless
        given), `callback`, `output`, `verbose`, `seed`, `save_history`, ...

    Attributes
    ----------
    state : the `DirectedState`.

    Raises
    ------
    TypeError, ValueError : for a parameter of the wrong type or out of range, or an unknown one.

    Examples
    --------
    >>> from pymoo.optimize import minimize
    >>> from pymoo.problems.multi import ZDT1
    >>> from mgeo import MGEODirected
    >>> result = minimize(ZDT1(n_var=4), MGEODirected(), ("n_eval", 2000), seed=1)
    >>> result.F.shape[1], bool(result.F.min() < 0.01)
    (2, True)
    """

    #: Probability a generation that a walker returns to its best point.
    return_probability: ClassVar[float] = 0.7
    #: Probabilities a generation that it goes to the archive's nearest point instead; rare at the
    #: extremes, where each walker may have a local optimum of its own.
    migration_probability: ClassVar[Pair] = (0.2, 0.02)
    #: Generations without progress after which a walker restarts: soon where other weights are all
    #: that it costs, late where it is the way to an optimum.
    patience: ClassVar[tuple[int, int]] = (4, 50)
    #: Smallest and largest share of the front's extent by which a best point must come nearer, to
    #: count as progress; between them it is 0.1 / n: the more points, the less is left between two.
    progress_threshold: ClassVar[Pair] = (1e-5, 1e-3)
    #: Smallest and largest standard deviation with which a walker begins to learn a covariance, of
    #: the bounds' width.
    initial_sigma_range: ClassVar[Pair] = (3e-3, 0.3)

    def __init__(
        self,
        tau: float = 3.0,
        n_walkers: int = 16,
        extreme_weights: float = 0.4,
        difference: Sequence[float] = (0.2, 0.65),
        momentum: Sequence[float] = (0.6, 0.6),
        max_candidates: int = 3,
        bounds: str = AUTO,
        **options: Any,
    ) -> None:
        super().__init__(tau=validate_number("tau", tau, low=0), n_walkers=n_walkers, **options)
        self.extreme_weights = validate_fraction("extreme_weights", extreme_weights)
        self.difference = validate_pair("difference", difference, validate_fraction)
        self.momentum = validate_pair("momentum", momentum, validate_fraction)
        self.max_candidates = validate_integer("max_candidates", max_candidates, low=1)
        self.bounds = validate_choice("bounds", bounds, (AUTO, *BOUNDS))

    def reset_walkers(self, rows: IntArray) -> None:
        super().reset_walkers(rows)
        state = self.state
        state.incumbents[rows] = state.walkers[rows]
        state.momentum[rows] = 0.0
        state.incumbent_F[rows] = state.reference_F[rows] = np.inf
        state.incumbent_violation[rows] = np.inf

    def accept(self, F: FloatArray, violation: FloatArray) -> BoolArray:
        state, rng, walker = self.state, self.random_state, np.arange(self.n_walkers)
        F = F.reshape(self.n_walkers, -1, F.shape[1])
        violation = np.where(np.isfinite(F).all(axis=2), violation.reshape(F.shape[:2]), np.inf)
        far = tchebycheff_distance(F, state.weights[:, None], *state.front.ideal_and_nadir)
        ranking = rank(far, violation, rng.random(far.shape))
        place = draw_position(rng.random(self.n_walkers), F.shape[1], float(self.tau))
        learning = self._select_adapting_walkers()
        means = state.walkers[learning]
        best = walker, ranking[:, 0]
        before = tchebycheff_distance(
            state.incumbent_F, state.weights, *state.front.ideal_and_nadir
        )
        self._update_credit(far, violation, before, learning)
        less = self._update_incumbents(
            self.proposals[best], F[best], violation[best], far[best], before
        )
        state.walkers = self.proposals[walker, ranking[walker, place]]
        self._return_to_incumbents(learning)
        if len(learning):
            state.walkers[learning] = means + self._adapt_distributions(learning, F, violation)
            np.clip(state.walkers, self.variables.xl, self.variables.xu, out=state.walkers)
        return less

    def _adapt_distributions(
        self, rows: IntArray, F: FloatArray, violation: FloatArray
    ) -> FloatArray:
        """(n, n_var) steps of the means of walkers, by what their candidates are worth."""
        state, normals = self.state, self.state.distributions
        if not normals.add_evaluations(F[rows], violation[rows]):
            return np.zeros((len(rows), state.walkers.shape[1]))
        far = tchebycheff_distance(
            normals.F, state.weights[rows, None], *state.front.ideal_and_nadir
        )
        ranking = rank(far, normals.violation, self.random_state.random(far.shape))
        return (self.variables.xu - self.variables.xl) * normals.adapt(ranking)

    def _update_credit(
        self,
        distances: FloatArray,
        violation: FloatArray,
        previous_distances: FloatArray,
        adaptive_rows: IntArray,
    ) -> None:
        """Account for the gains of the candidates along the weights, except of learning walkers."""
        known = self.state.incumbent_violation == 0
        known[adaptive_rows] = False
        gains = np.where(
            (violation == 0) & known[:, None], previous_distances[:, None] - distances, 0.0
        )
        gains = np.where(gains > 0, gains, 0.0)  # NaN of failed candidates as well
        others = np.delete(np.arange(self.n_walkers), adaptive_rows)
        self.state.credit.update(gains[others], self.is_recombined[others])

    def _update_incumbents(
        self,
        points: FloatArray,
        F: FloatArray,
        violation: FloatArray,
        distances: FloatArray,
        previous_distances: FloatArray,
    ) -> BoolArray:
        """Update the incumbents; tells whose constraint violation is less than ever."""
        state = self.state
        less = violation < state.incumbent_violation
        feasible = (violation == 0) & (state.incumbent_violation == 0)
        better = less | (feasible & (distances < previous_distances))
        state.momentum[better] = points[better] - state.walkers[better]
        state.incumbents[better] = points[better]
        state.incumbent_F[better] = F[better]
        state.incumbent_violation[better] = violation[better]
        return np.asarray(less)

    def _return_to_incumbents(self, adaptive_rows: IntArray) -> None:
        """Let some walkers return to their incumbents, and some that do not learn migrate."""
        state, chance = self.state, self.random_state.random(self.n_walkers)
        returns = (chance < self.return_probability) & np.isfinite(state.incumbent_violation)
        state.walkers[returns] = state.incumbents[returns]
        migrate = self.return_probability + self._select_by_weights(self.migration_probability)
        chance[adaptive_rows] = 1.0
        self._migrate(np.flatnonzero((chance >= self.return_probability) & (chance < migrate)))

    def _migrate(self, rows: IntArray) -> None:
        """Put walkers on the archive's points nearest along their weight vectors."""
        state, front = self.state, self.state.front
        if not len(rows) or not len(front):
            return
        nearest = self._find_nearest(rows)
        points = self.get_archived_points(nearest)
        state.momentum[rows] = points - state.walkers[rows]
        state.walkers[rows] = state.incumbents[rows] = points
        state.incumbent_F[rows] = front.F[nearest]
        state.incumbent_violation[rows] = front.violation

    def restart_idle_walkers(
        self, has_progress: BoolArray, has_archived_candidate: BoolArray
    ) -> None:
        # progress is less violation, or a feasible incumbent that has come nearer by enough
        state = self.state
        ideal, nadir = state.front.ideal_and_nadir
        far, before = (
            tchebycheff_distance(F, state.weights, ideal, nadir)
            for F in (state.incumbent_F, state.reference_F)
        )
        # the nearer the front's points are to each other, the less there is to come nearer by
        smallest, largest = self.progress_threshold
        share = min(max(_PROGRESS_FACTOR / max(len(state.front), 1), smallest), largest)
        least = share if (ideal < nadir).all() else 0.0  # one objective has no extent
        feasible = state.incumbent_violation == 0
        nearer = feasible & ~(far >= before - least)  # true where nothing is marked yet
        state.reference_F[nearer] = state.incumbent_F[nearer]
        state.n_idle_generations = np.where(nearer | has_progress, 0, state.n_idle_generations + 1)
        between = self._has_mixed_weights()
        idle = state.n_idle_generations >= self._select_by_weights(self.patience)
        if len(rows := self._select_adaptive_walkers(state.weights)) and self._is_adaptation_due():
            idle[rows] = False
            self._start_distributions(rows)
        if len(rows := np.flatnonzero(idle & between)) and len(state.front):
            state.weights[rows] = draw_weights(len(rows), state.weights.shape[1], self.random_state)
            self._migrate(rows)
            state.reference_F[rows] = state.incumbent_F[rows]
            state.n_idle_generations[rows] = 0
        if len(rows := np.flatnonzero(idle & ~between)):
            self.restart_walkers(rows)

    def _is_adaptation_due(self) -> bool:
        made = (self.state.n_generations + 1) * self.n_walkers * self._n_candidates
        return made >= self.adaptation_delay * len(self.variables.xl) and len(self.state.front) > 0

    def _start_distributions(self, rows: IntArray) -> None:
        """Let distributions begin at the archive's nearest points: all, and later those in vain."""
        state, normals, rng = self.state, self.state.distributions, self.random_state
        if normals.n_drawn:
            return
        patience = (10 + len(self.variables.xl)) * (normals.z.shape[1] // self._n_candidates)
        narrow, wide = _SIGMA_LIMITS
        goes_on = (
            (normals.max_sigma > narrow)
            & (normals.max_sigma < wide)
            & (state.n_idle_generations[rows] < patience)
        )
        if not len(which := np.flatnonzero(~goes_on)):
            return
        rows = rows[which]
        drawn = rows[self._has_mixed_weights()[rows]]
        state.weights[drawn] = draw_weights(len(drawn), state.weights.shape[1], rng)
        state.walkers[rows] = self.get_archived_points(self._find_nearest(rows))
        self.reset_walkers(rows)
        normals.reset(which, np.exp(rng.uniform(*np.log(self.initial_sigma_range), len(rows))))
