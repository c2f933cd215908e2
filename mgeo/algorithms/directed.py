"""MGEODirected, decomposition-based extremal optimization with cooperating walkers."""

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

#: Progress threshold times the number of points of the front, as a fraction of the extent of the
#: front. The threshold follows the distance between neighboring points.
_PROGRESS_FACTOR = 0.1
#: Smallest and largest standard deviation of a search distribution, as a fraction of the width of
#: the bounds. A distribution outside this range restarts.
_SIGMA_LIMITS = 1e-6, 10.0


class MGEODirected(DirectedMoves):
    """Decomposition-based extremal optimization: each walker searches its own part of the front.

    As in MGEO_real, a walker generates candidates that change one variable or more, ranks them, and
    accepts the candidate of rank k with a probability proportional to k^-tau, even if the candidate
    is worse than the current point. Four mechanisms differ from MGEO_real:

    - **Decomposition.** A walker ranks its candidates by the weighted Tchebycheff distance for its
      weight vector, with objectives scaled by the current front. A share of the walkers has extreme
      weights, for a single objective. The weights of the other walkers are mixed and spread evenly.
    - **Four kinds of candidates.** Recombination crosses two good points variable by variable and
      mutates one variable on average (genetic algorithms; Deb & Agrawal 1995); its share of the
      candidates follows its gains (`mgeo.algorithms.recombination`). A step with momentum continues
      the step that led to the walker's best point and moves towards an archived point, in all
      variables (particle swarms; Zhang et al. 2018). A difference step is a fraction of the
      difference between two good points, in many variables (differential evolution; Storn & Price
      1997). A Gaussian step usually changes a single variable.
    - **Return.** After most generations, a walker returns to its best point or, more rarely, to the
      archived point that is nearest to its weight vector.
    - **Restart.** A walker without progress restarts. A walker with mixed weights draws a new
      weight vector. A walker with extreme weights starts at a random point, because it may be in a
      local optimum.

    In long runs, after 2,000 evaluations per variable, half of the walkers draw their candidates
    from a normal distribution with an adaptive covariance.

    Variables can be real or, with `Problem(vars=...)`, also integer, binary or choices. The steps
    of integer and binary variables are rounded, and a choice takes the option of another good
    point. A generation takes n_walkers x min(n_var, max_candidates) evaluations. The search does
    not depend on the termination. With a single objective, all walkers minimize this objective.

    Parameters
    ----------
    tau : selection pressure, >= 0: the candidate of rank k is accepted with probability ~ k^-tau.
    n_walkers : number of walkers, the parallel search trajectories.
    extreme_weights : share of the walkers that minimize a single objective, in [0, 1]. The other
        walkers have mixed weights.
    momentum : probability of a step with momentum if the candidate is not a recombination, in
        [0, 1]. Two values: for walkers with mixed weights, and for walkers that minimize a single
        objective. The latter take such a step only if, in each variable, the archived point is
        at most a fifth of the width of the bounds away from the walker's current point.
    difference : probability of a difference step if the candidate is neither a recombination nor a
        step with momentum, in [0, 1]. Two values, as for momentum.
    max_candidates : largest number of candidates per walker and generation, limited to the number
        of variables. Each Gaussian or difference step always changes one variable, a different one
        for each candidate of the walker. It changes each other variable with a probability drawn
        at random for the step.
    bounds : treatment of steps beyond the bounds: "clip" to the bound, "reflect" at the bound, or
        "resample" until the step stays inside. "auto" reflects if the problem has equality
        constraints, and clips otherwise.
    options : `sampling` and `archive_size` of `mgeo.algorithms.base.ExtremalOptimization`, and
        options of every pymoo algorithm: `termination` (5000 // n_walkers generations by default),
        `callback`, `output`, `verbose`, `seed`, `save_history`, ...

    Attributes
    ----------
    state : DirectedState
        Data that persist between generations.

    Raises
    ------
    TypeError, ValueError
        If a parameter is unknown, has the wrong type or is out of range.

    Examples
    --------
    >>> from pymoo.optimize import minimize
    >>> from pymoo.problems.multi import ZDT1
    >>> from mgeo import MGEODirected
    >>> result = minimize(ZDT1(n_var=4), MGEODirected(), ("n_eval", 2000), seed=1)
    >>> result.F.shape[1], bool(result.F.min() < 0.01)
    (2, True)
    """

    #: Probability that a walker returns to its best point after a generation.
    return_probability: ClassVar[float] = 0.7
    #: Probability that a walker moves to the nearest archived point instead, for walkers with mixed
    #: and with extreme weights. The second number is small, because each walker with extreme
    #: weights may search near another local optimum.
    migration_probability: ClassVar[Pair] = (0.2, 0.02)
    #: Generations without progress before a restart, for walkers with mixed and with extreme
    #: weights. A walker with mixed weights loses little by a restart, because it continues at an
    #: archived point. A walker with extreme weights continues at a random point.
    patience: ClassVar[tuple[int, int]] = (4, 50)
    #: Smallest and largest decrease of the distance that counts as progress, as a fraction of the
    #: extent of the front. In this range the threshold is 0.1 / n for n points of the front,
    #: because the distance between neighboring points decreases with n.
    progress_threshold: ClassVar[Pair] = (1e-5, 1e-3)
    #: Smallest and largest initial standard deviation of a search distribution, as a fraction of
    #: the width of the bounds.
    initial_sigma_range: ClassVar[Pair] = (3e-3, 0.3)

    def __init__(
        self,
        tau: float = 3.0,
        n_walkers: int = 16,
        extreme_weights: float = 0.4,
        momentum: Sequence[float] = (0.6, 0.6),
        difference: Sequence[float] = (0.2, 0.65),
        max_candidates: int = 3,
        bounds: str = AUTO,
        **options: Any,
    ) -> None:
        super().__init__(tau=validate_number("tau", tau, low=0), n_walkers=n_walkers, **options)
        self.extreme_weights = validate_fraction("extreme_weights", extreme_weights)
        self.momentum = validate_pair("momentum", momentum, validate_fraction)
        self.difference = validate_pair("difference", difference, validate_fraction)
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
        distances = tchebycheff_distance(F, state.weights[:, None], *state.front.ideal_and_nadir)
        ranking = rank(distances, violation, rng.random(distances.shape))
        position = draw_position(rng.random(self.n_walkers), F.shape[1], float(self.tau))
        adaptive_rows = self._select_adapting_walkers()
        means = state.walkers[adaptive_rows]
        best = walker, ranking[:, 0]
        previous_distances = tchebycheff_distance(
            state.incumbent_F, state.weights, *state.front.ideal_and_nadir
        )
        self._update_credit(distances, violation, previous_distances, adaptive_rows)
        has_less_violation = self._update_incumbents(
            self.proposals[best], F[best], violation[best], distances[best], previous_distances
        )
        state.walkers = self.proposals[walker, ranking[walker, position]]
        self._return_to_incumbents(adaptive_rows)
        if len(adaptive_rows):
            mean_steps = self._adapt_distributions(adaptive_rows, F, violation)
            state.walkers[adaptive_rows] = means + mean_steps
            np.clip(state.walkers, self.variables.xl, self.variables.xu, out=state.walkers)
        return has_less_violation

    def _adapt_distributions(
        self, rows: IntArray, F: FloatArray, violation: FloatArray
    ) -> FloatArray:
        """Adapt the search distributions of the selected walkers to their evaluated candidates.

        Return the steps of the distribution means, with one row per walker. The steps are 0 until
        the samples of the distributions are complete.
        """
        state, distributions = self.state, self.state.distributions
        if not distributions.add_evaluations(F[rows], violation[rows]):
            return np.zeros((len(rows), state.walkers.shape[1]))
        distances = tchebycheff_distance(
            distributions.F, state.weights[rows, None], *state.front.ideal_and_nadir
        )
        ranking = rank(
            distances, distributions.violation, self.random_state.random(distances.shape)
        )
        return (self.variables.xu - self.variables.xl) * distributions.adapt(ranking)

    def _update_credit(
        self,
        distances: FloatArray,
        violation: FloatArray,
        previous_distances: FloatArray,
        adaptive_rows: IntArray,
    ) -> None:
        """Add the improvements of this generation to the totals of recombined and other candidates.

        An improvement is a decrease of the distance compared to the incumbent of the walker.
        Walkers that adapt a covariance are excluded.
        """
        has_reference = self.state.incumbent_violation == 0
        has_reference[adaptive_rows] = False
        gains = np.where(
            (violation == 0) & has_reference[:, None], previous_distances[:, None] - distances, 0.0
        )
        gains = np.where(gains > 0, gains, 0.0)  # The gain of a failed candidate is NaN.
        rows = np.delete(np.arange(self.n_walkers), adaptive_rows)
        self.state.credit.update(gains[rows], self.is_recombined[rows])

    def _update_incumbents(
        self,
        points: FloatArray,
        F: FloatArray,
        violation: FloatArray,
        distances: FloatArray,
        previous_distances: FloatArray,
    ) -> BoolArray:
        """Replace the incumbent of each walker whose best candidate is better.

        Returns
        -------
        array of bool, shape (n_walkers,)
            True for each walker whose smallest constraint violation decreased.
        """
        state = self.state
        has_less_violation = violation < state.incumbent_violation
        both_feasible = (violation == 0) & (state.incumbent_violation == 0)
        better = has_less_violation | (both_feasible & (distances < previous_distances))
        state.momentum[better] = points[better] - state.walkers[better]
        state.incumbents[better] = points[better]
        state.incumbent_F[better] = F[better]
        state.incumbent_violation[better] = violation[better]
        return np.asarray(has_less_violation)

    def _return_to_incumbents(self, adaptive_rows: IntArray) -> None:
        """Move randomly selected walkers back to their best points or to archived points.

        Walkers that adapt a covariance do not move to archived points.
        """
        state, uniform = self.state, self.random_state.random(self.n_walkers)
        returns = (uniform < self.return_probability) & np.isfinite(state.incumbent_violation)
        state.walkers[returns] = state.incumbents[returns]
        threshold = self.return_probability + self._select_by_weights(self.migration_probability)
        uniform[adaptive_rows] = 1.0
        self._migrate(np.flatnonzero((uniform >= self.return_probability) & (uniform < threshold)))

    def _migrate(self, rows: IntArray) -> None:
        """Move the selected walkers to the archived points nearest to their weight vectors."""
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
        # Progress is a smaller constraint violation, or a feasible incumbent whose distance has
        # decreased by the threshold since the last progress.
        state = self.state
        ideal, nadir = state.front.ideal_and_nadir
        distances, reference_distances = (
            tchebycheff_distance(F, state.weights, ideal, nadir)
            for F in (state.incumbent_F, state.reference_F)
        )
        smallest, largest = self.progress_threshold
        threshold = min(max(_PROGRESS_FACTOR / max(len(state.front), 1), smallest), largest)
        if not (ideal < nadir).all():
            threshold = 0.0  # The front has no extent, as with a single objective.
        is_feasible = state.incumbent_violation == 0
        # The negation makes the comparison true for new walkers, whose reference distance is NaN.
        is_nearer = is_feasible & ~(distances >= reference_distances - threshold)
        state.reference_F[is_nearer] = state.incumbent_F[is_nearer]
        state.n_idle_generations = np.where(
            is_nearer | has_progress, 0, state.n_idle_generations + 1
        )
        has_mixed_weights = self._has_mixed_weights()
        is_idle = state.n_idle_generations >= self._select_by_weights(self.patience)
        if len(rows := self._select_adaptive_walkers(state.weights)) and self._is_adaptation_due():
            is_idle[rows] = False
            self._start_distributions(rows)
        if len(rows := np.flatnonzero(is_idle & has_mixed_weights)) and len(state.front):
            state.weights[rows] = draw_weights(len(rows), state.weights.shape[1], self.random_state)
            self._migrate(rows)
            state.reference_F[rows] = state.incumbent_F[rows]
            state.n_idle_generations[rows] = 0
        if len(rows := np.flatnonzero(is_idle & ~has_mixed_weights)):
            self.restart_walkers(rows)

    def _is_adaptation_due(self) -> bool:
        n_candidates = (self.state.n_generations + 1) * self.n_walkers * self._n_candidates
        is_after_delay = n_candidates >= self.adaptation_delay * len(self.variables.xl)
        return is_after_delay and len(self.state.front) > 0

    def _start_distributions(self, rows: IntArray) -> None:
        """Start new search distributions, and restart those that converged, diverged or stagnated.

        The means are the archived points that are nearest to the weight vectors. Walkers with mixed
        weights draw new weight vectors. `rows` are the indices of the walkers that adapt a
        covariance.
        """
        state, distributions, rng = self.state, self.state.distributions, self.random_state
        if distributions.n_drawn:
            return
        patience = (10 + len(self.variables.xl)) * (distributions.z.shape[1] // self._n_candidates)
        narrowest, widest = _SIGMA_LIMITS
        continues = (
            (distributions.max_sigma > narrowest)
            & (distributions.max_sigma < widest)
            & (state.n_idle_generations[rows] < patience)
        )
        if not len(restarted := np.flatnonzero(~continues)):
            return
        rows = rows[restarted]
        mixed_rows = rows[self._has_mixed_weights()[rows]]
        state.weights[mixed_rows] = draw_weights(len(mixed_rows), state.weights.shape[1], rng)
        state.walkers[rows] = self.get_archived_points(self._find_nearest(rows))
        self.reset_walkers(rows)
        sigma = np.exp(rng.uniform(*np.log(self.initial_sigma_range), len(rows)))
        distributions.reset(restarted, sigma)
