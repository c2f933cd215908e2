"""Candidates of `MGEODirected`: Gaussian steps, differences, momentum and recombination.

`DirectedMoves` generates the candidates of a generation; the functions draw the steps.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import ClassVar, NamedTuple

import numpy as np
from pymoo.core.problem import Problem

from mgeo._typing import BoolArray, FloatArray, IntArray
from mgeo.algorithms.archive import ParetoArchive
from mgeo.algorithms.base import ExtremalOptimization
from mgeo.algorithms.encoding import RealEncoding
from mgeo.algorithms.matrix_adaptation import SearchDistributions
from mgeo.algorithms.recombination import RecombinationCredit, recombine
from mgeo.algorithms.run_state import RunState
from mgeo.algorithms.selection import build_weight_vectors, find_nearest, find_nearest_in_sample
from mgeo.algorithms.steps import NORMAL, get_bounding, round_steps
from mgeo.algorithms.variables import KINDS, Variables

Pair = tuple[float, float]
#: Function of a shape (...) that returns pairs of points as two arrays of shape (..., n_var).
Donors = Callable[[tuple[int, ...]], tuple[FloatArray, FloatArray]]


class Attraction(NamedTuple):
    """Settings that pull difference steps (differential evolution) towards good points.

    This is the move "current-to-best" (Zhang & Sanderson, "JADE", IEEE Trans. Evol. Comput. 13,
    2009, equation 6), except that a step covers a random fraction of the distance to the target,
    uniform in [0, 1).

    Attributes
    ----------
    share : float
        Share of the difference steps that are attracted.
    coupling : float
        Mean probability that an attracted step changes another variable than its primary one.
    start : array, shape (..., n_var)
        Points at which the steps begin.
    target : array, shape (..., n_var)
        Points towards which the steps are attracted.
    """

    share: float
    coupling: float
    start: FloatArray
    target: FloatArray


#: Largest factor of the previous step in a step with momentum.
_MAX_INERTIA = 1.2
#: Largest change of a variable by a step with momentum, as a fraction of the width of its bounds.
_MAX_STEP = 0.2


def draw_momentum_steps(
    x: FloatArray,
    previous_steps: FloatArray,
    targets: FloatArray,
    extent: FloatArray,
    rng: np.random.Generator,
) -> FloatArray:
    """Draw steps with momentum and attraction to a target, as in particle swarm optimization.

    A step is r1 previous_step + r2 (target - x), with r1 uniform in [0, 1.2) and r2 in [0, 1),
    drawn separately for each variable (Zhang et al., "A competitive mechanism based multi-objective
    particle swarm optimizer with fast convergence", Information Sciences 427, 2018, equation 3). In
    this variant, the previous step is the last step that improved a walker. No variable changes by
    more than a fifth of the width of its bounds.

    Parameters
    ----------
    x : array, shape (..., n_var)
        Points at which the steps begin.
    previous_steps : array, shape (..., n_var)
        Previous steps, which broadcast with `x`.
    targets : array, shape (..., n_var)
        Target points, which broadcast with `x`.
    extent : array, shape (n_var,)
        Width of the bounds.
    rng : numpy.random.Generator

    Returns
    -------
    array, shape (..., n_var)
        Steps of all variables.
    """
    offset = targets - x
    step = (
        _MAX_INERTIA * rng.random(offset.shape) * previous_steps + rng.random(offset.shape) * offset
    )
    return np.clip(step, -_MAX_STEP * extent, _MAX_STEP * extent)


def is_within_reach(x: FloatArray, targets: FloatArray, extent: FloatArray) -> BoolArray:
    """Return True for each target that a single momentum step from `x` can reach.

    A target is within reach if no variable differs by more than a fifth of the width of its bounds.

    Parameters
    ----------
    x, targets : array, shape (..., n_var)
        Points and targets.
    extent : array, shape (n_var,)
        Width of the bounds.

    Returns
    -------
    array of bool, shape (...)
    """
    return np.asarray((np.abs(targets - x) <= _MAX_STEP * extent).all(axis=-1))


def draw_joint_steps(
    primary: IntArray,
    extent: FloatArray,
    sigma_range: Sequence[float],
    coupling: Sequence[float],
    difference_share: float | FloatArray,
    donors: Donors | None,
    rng: np.random.Generator,
    attraction: Attraction | None = None,
) -> tuple[FloatArray, FloatArray, FloatArray | None]:
    """Draw random steps that change several variables at once.

    Each step is either a Gaussian step or a difference step. A Gaussian step has a random standard
    deviation, log-uniform in `sigma_range`. A difference step is a random fraction, uniform in [0,
    1), of the difference between two points (differential evolution; Storn & Price 1997).

    Every step changes its primary variable. The probability that the step changes each of the other
    variables is u^(1/mean - 1), with u uniform in [0, 1) and drawn once per step. Some steps
    therefore change hardly any other variable and some change nearly all, so that the search suits
    problems with independent and with coupled variables.

    Parameters
    ----------
    primary : array of int, shape (...)
        Primary variable of each step.
    extent : array, shape (n_var,)
        Width of the bounds.
    sigma_range : pair of float
        Smallest and largest standard deviation of a Gaussian step, as a fraction of `extent`.
    coupling : pair of float
        Mean probability that another variable changes, for Gaussian steps and for difference steps.
    difference_share : float or array that broadcasts with `primary`
        Probability that a step is a difference step.
    donors : function, optional
        Returns the pairs of points of the difference steps. None for Gaussian steps only.
    rng : numpy.random.Generator
    attraction : Attraction, optional
        Attraction of some difference steps towards other points.

    Returns
    -------
    steps : array, shape (..., n_var)
        Steps, 0 for variables that do not change.
    spread : array, shape (..., n_var)
        Standard deviations of the Gaussian steps, 0 for difference steps.
    donor : array, shape (..., n_var), or None
        Points towards which the steps move: the first points of the pairs, or the targets of the
        attraction. None without `donors`.
    """
    shape = *primary.shape, len(extent)
    log_min, log_max = np.log(sigma_range)
    sigma = np.exp(rng.uniform(log_min, log_max, primary.shape))[..., None]
    spread = sigma * extent
    step = spread * rng.standard_normal(shape)
    mean = np.full(primary.shape, coupling[0])
    donor = None
    if donors is not None:
        is_difference = rng.random(primary.shape) < difference_share
        donor, second = donors(primary.shape)
        difference = donor - second
        step = np.where(
            is_difference[..., None], rng.random(primary.shape)[..., None] * difference, step
        )
        spread[is_difference] = 0.0
        mean[is_difference] = coupling[1]
        if attraction is not None:
            is_attracted = is_difference & (rng.random(primary.shape) < attraction.share)
            offset = rng.random(primary.shape)[..., None] * (attraction.target - attraction.start)
            step = np.where(is_attracted[..., None], step + offset, step)
            mean[is_attracted] = attraction.coupling
            donor = np.where(is_attracted[..., None], attraction.target, donor)
    with np.errstate(divide="ignore"):  # With a mean of 0, the probability is u^inf = 0.
        probability = rng.random(primary.shape) ** (1.0 / mean - 1.0)
    is_changed = rng.random(shape) < probability[..., None]
    np.put_along_axis(is_changed, primary[..., None], True, axis=-1)
    return np.where(is_changed, step, 0.0), spread, donor


@dataclass(kw_only=True, eq=False, slots=True)
class DirectedState(RunState):
    """State of an `MGEODirected` run between two generations.

    Attributes
    ----------
    weights : array, shape (n_walkers, n_obj)
        Weight vectors of the walkers.
    incumbents : array, shape (n_walkers, n_var)
        Best point of each walker since its start.
    momentum : array, shape (n_walkers, n_var)
        Step that led to the incumbent; 0 for a new walker.
    incumbent_F : array, shape (n_walkers, n_obj)
        Objectives of the incumbents, infinite for a new walker.
    incumbent_violation : array, shape (n_walkers,)
        Constraint violations of the incumbents, infinite for a new walker.
    reference_F : array, shape (n_walkers, n_obj)
        Objectives of the incumbents at the last progress of each walker, from which further
        progress is measured. `n_idle_generations` counts the generations since then.
    distributions : SearchDistributions
        Normal distributions of the walkers that adapt a covariance.
    credit : RecombinationCredit
        Recent gains by recombined candidates and by all other candidates.
    """

    weights: FloatArray
    incumbents: FloatArray
    momentum: FloatArray
    incumbent_F: FloatArray
    incumbent_violation: FloatArray
    reference_F: FloatArray
    distributions: SearchDistributions
    credit: RecombinationCredit


class DirectedMoves(ExtremalOptimization):
    """Base class of `MGEODirected` that generates the candidates of each generation.

    A subclass declares the parameters `extreme_weights`, `difference`, `momentum`,
    `max_candidates` and `bounds`, and implements `accept` and `restart_idle_walkers`. The class
    constants were tuned by a parameter search; docs/studies/parts.md shows the loss without each
    mechanism. A derived class can override them.

    A walker has *mixed* weights if several objectives have positive weight, and *extreme* weights
    if only one has.
    """

    #: Mean probability that a step changes each variable other than its primary one, for normal
    #: steps and for difference steps (see `draw_joint_steps`). A difference step that changed all
    #: variables could copy the point of its donor.
    coupling: ClassVar[Pair] = (0.05, 0.5)
    #: Smallest and largest standard deviation of Gaussian steps, as a fraction of the width of the
    #: bounds. The range is wide, because the right scale is unknown.
    sigma_range: ClassVar[Pair] = (1e-3, 1.0)
    #: Share of the difference steps that are attracted to the archived point nearest to the
    #: walker's weight vector, and mean probability that an attracted step changes each other
    #: variable. The probability is high, because progress along a curved valley needs steps of
    #: nearly all variables.
    attraction: ClassVar[Pair] = (0.5, 0.9)
    #: Share of the steps with momentum whose target is the nearest of all n archived points, and
    #: factor c. The target of all other steps is the nearest of c sqrt(n) random archived points,
    #: at least one. The sample grows with the archive, because distant targets would move walkers
    #: along the front instead of towards better points.
    target_selection: ClassVar[Pair] = (0.3, 0.33)
    #: Smallest and largest share of the candidates that recombine two points. Within this range,
    #: the share follows the gains by recombined candidates (see
    #: `recombination.RecombinationCredit`).
    recombination: ClassVar[Pair] = (0.02, 0.9)
    #: Share of the walkers that adapt a covariance, of the walkers with mixed weights and of the
    #: walkers with extreme weights.
    adaptive_share: ClassVar[float] = 0.5
    #: Evaluations per variable before walkers begin to adapt a covariance. Compared to a delay of
    #: 500, multimodal functions gain and unimodal functions lose a little.
    adaptation_delay: ClassVar[int] = 2000
    #: Largest number of variables for which walkers adapt a covariance, because the cost of larger
    #: matrices is too high.
    max_adaptive_variables: ClassVar[int] = 100

    state: DirectedState
    extreme_weights: float
    difference: Sequence[float]
    momentum: Sequence[float]
    max_candidates: int
    bounds: str
    #: Mask of the recombined candidates of the current generation, shape (n_walkers,
    #: candidates per walker). `generate_candidates` sets it for `accept`.
    is_recombined: BoolArray

    def build_encoding(self, problem: Problem) -> RealEncoding:
        return RealEncoding(Variables.from_problem(problem, KINDS))

    def create_state(
        self, streams: list[np.random.Generator], front: ParetoArchive, walkers: FloatArray
    ) -> DirectedState:
        n, n_obj = len(walkers), front.F.shape[1]
        weights = build_weight_vectors(n, n_obj, self.extreme_weights)
        return DirectedState.create(
            streams,
            front,
            walkers,
            weights=weights,
            incumbents=np.empty_like(walkers),
            momentum=np.empty_like(walkers),
            incumbent_F=np.empty((n, n_obj)),
            incumbent_violation=np.empty(n),
            reference_F=np.empty((n, n_obj)),
            distributions=SearchDistributions.create(
                len(self._select_adaptive_walkers(weights)),
                walkers.shape[1],
                n_obj,
                self._n_candidates,
            ),
            credit=RecombinationCredit.create(n * self._n_candidates),
        )

    def generate_candidates(self) -> FloatArray:
        xl, xu = self.variables.xl, self.variables.xu
        primary = np.broadcast_to(np.arange(len(xl)), (self.n_walkers, len(xl)))
        if len(xl) > self.max_candidates:
            primary = self.random_state.permuted(primary, axis=1)[:, : self.max_candidates]
        donors = attraction = None
        if len(self.front):
            donors = self._draw_donors
            nearest_points = self.get_archived_points(self._find_nearest())
            share, coupling = self.attraction
            if share:
                attraction = Attraction(
                    share, coupling, self.walkers[:, None], nearest_points[:, None]
                )
        difference_share = self._select_by_weights(self.difference)[:, None]
        steps, spread, donor = draw_joint_steps(
            primary, xu - xl, self.sigma_range, self.coupling, difference_share, donors,
            self.random_state, attraction,
        )  # fmt: skip
        if donor is not None and any(self.momentum):
            self._apply_momentum(steps, spread, donor, nearest_points)
        self.is_recombined = np.zeros(steps.shape[:2], dtype=np.bool_)
        if donor is not None and len(self.front) > 1 and any(self.recombination):
            self._recombine(steps, spread, donor, nearest_points)
        if len(rows := self._select_adapting_walkers()):
            steps[rows] = (xu - xl) * self.state.distributions.draw_steps(
                self._n_candidates, self.random_state
            )
            spread[rows], self.is_recombined[rows] = 0.0, False
        walkers, uniform = self.walkers[:, None, :], partial(self.random_state.random, steps.shape)
        bounding = get_bounding(self.bounds, self.problem.n_eq_constr)
        self.proposals = bounding(walkers, steps, spread, xl, xu, uniform, NORMAL)
        is_discrete = ~self.variables.is_real
        if is_discrete.any():
            # A Gaussian step has no donor from which a choice could take its option.
            options = np.full(steps.shape, np.nan) if donor is None else donor
            options = np.where((spread == 0.0).all(axis=-1, keepdims=True), options, np.nan)
            rounded = round_steps(
                walkers, self.proposals, primary, options, self.variables.is_choice, xl, xu,
                uniform(),
            )  # fmt: skip
            self.proposals = np.where(is_discrete, rounded, self.proposals)
        return self.proposals.reshape(-1, len(xl))

    def _apply_momentum(
        self, steps: FloatArray, spread: FloatArray, donor: FloatArray, nearest_points: FloatArray
    ) -> None:
        """Replace randomly selected steps with steps that continue each walker's last improvement.

        Parameters
        ----------
        steps, spread, donor : array, shape (n_walkers, n_candidates, n_var)
            Return values of `draw_joint_steps`, modified in place.
        nearest_points : array, shape (n_walkers, n_var)
            Archived point nearest to the weight vector of each walker.
        """
        rng, state = self.random_state, self.state
        is_replaced = rng.random(steps.shape[:2]) < self._select_by_weights(self.momentum)[:, None]
        rows, columns = np.nonzero(is_replaced)
        if not len(rows):
            return
        share, factor = self.target_selection
        sampled = self._find_nearest_in_sample(rows, factor * len(self.front) ** 0.5)
        targets = np.where(
            rng.random((len(rows), 1)) < share,
            nearest_points[rows],
            self.get_archived_points(sampled),
        )
        # The options of a choice have no order, and so no distance.
        x, is_choice = self.walkers[rows], self.variables.is_choice
        extent = self.variables.xu - self.variables.xl
        is_allowed = (
            is_within_reach(x, np.where(is_choice, x, targets), extent)
            | self._has_mixed_weights()[rows]
        )
        is_replaced[rows[~is_allowed], columns[~is_allowed]] = False
        rows, targets = rows[is_allowed], targets[is_allowed]
        previous_steps = np.where(is_choice, 0.0, state.momentum[rows])
        steps[is_replaced] = draw_momentum_steps(
            x[is_allowed], previous_steps, targets, extent, rng
        )
        spread[is_replaced], donor[is_replaced] = 0.0, targets

    def _recombine(
        self, steps: FloatArray, spread: FloatArray, donor: FloatArray, nearest_points: FloatArray
    ) -> None:
        """Replace randomly selected steps with steps to the offspring of two good points.

        For a walker with mixed weights, the first parent is the incumbent of the walker or its
        nearest archived point, and the second parent is the nearest of sqrt(n) random points of the
        n archived points. A walker with extreme weights may search near another local optimum than
        the archive; its parents are its own incumbent and the incumbent of a random walker.

        Parameters
        ----------
        steps, spread, donor : array, shape (n_walkers, n_candidates, n_var)
            Return values of `draw_joint_steps`, modified in place.
        nearest_points : array, shape (n_walkers, n_var)
            Archived point nearest to the weight vector of each walker.
        """
        rng, state, variables = self.random_state, self.state, self.variables
        is_replaced = rng.random(steps.shape[:2]) < state.credit.compute_share(*self.recombination)
        rows, _ = np.nonzero(is_replaced)
        if not len(rows):
            return
        has_mixed_weights = self._has_mixed_weights()[rows, None]
        is_from_archive = has_mixed_weights & (rng.random((len(rows), 1)) < 0.5)
        first = np.where(is_from_archive, nearest_points[rows], state.incumbents[rows])
        archived = self.get_archived_points(
            self._find_nearest_in_sample(rows, len(state.front) ** 0.5)
        )
        incumbents = state.incumbents[rng.integers(self.n_walkers, size=len(rows))]
        second = np.where(has_mixed_weights, archived, incumbents)
        points = recombine(first, second, variables.xl, variables.xu, variables.is_choice, rng)
        steps[is_replaced] = points - self.walkers[rows]
        spread[is_replaced], donor[is_replaced] = 0.0, points
        self.is_recombined = is_replaced

    def _find_nearest(self, rows: IntArray | slice = slice(None)) -> IntArray:
        """Return the index of the best archived point for the weight vector of each walker."""
        state, F = self.state, self.state.front.F
        return find_nearest(F, state.weights[rows], *state.front.ideal_and_nadir)

    def _find_nearest_in_sample(self, rows: IntArray, n_sampled: float) -> IntArray:
        """Find the nearest of several random archived points for each walker.

        The nearest point has the smallest Tchebycheff distance for the weight vector of the walker.
        The result is its index. `n_sampled` is rounded down, but at least one point is drawn.
        """
        front = self.state.front
        size = len(rows), max(1, int(n_sampled))
        sample = self.random_state.integers(len(front), size=size)
        return find_nearest_in_sample(
            sample, front.F, self.state.weights[rows], *front.ideal_and_nadir
        )

    def _draw_donors(self, shape: tuple[int, ...]) -> tuple[FloatArray, FloatArray]:
        """Draw pairs of points from the archive and the incumbents to compute difference steps."""
        rng, n = self.random_state, len(self.front)
        donors = []
        for _ in range(2):
            rows = rng.integers(n, size=shape)
            incumbents = self.state.incumbents[rng.integers(self.n_walkers, size=shape)]
            is_from_archive = rng.random((*shape, 1)) < 0.5
            archived = self.get_archived_points(rows.ravel()).reshape(incumbents.shape)
            donors.append(np.where(is_from_archive, archived, incumbents))
        return donors[0], donors[1]

    @property
    def _n_candidates(self) -> int:
        return min(len(self.variables.xl), self.max_candidates)

    def _select_adaptive_walkers(self, weights: FloatArray) -> IntArray:
        """Return the indices of the walkers that will draw steps from adaptive distributions.

        These walkers start to use their distributions as soon as enough designs have been
        evaluated. They are the last walkers with mixed weights, followed by the last walkers with
        extreme weights.
        """
        if not self.variables.is_real.all() or len(self.variables.xl) > self.max_adaptive_variables:
            return np.empty(0, dtype=np.intp)
        has_mixed_weights = weights.max(axis=1) < 1
        groups = np.flatnonzero(has_mixed_weights), np.flatnonzero(~has_mixed_weights)
        return np.concatenate(
            [rows[len(rows) - round(self.adaptive_share * len(rows)) :] for rows in groups]
        )

    def _select_adapting_walkers(self) -> IntArray:
        """Return the indices of the walkers that already draw steps from adaptive distributions."""
        rows = self._select_adaptive_walkers(self.state.weights)
        return rows[self.state.distributions.sigma > 0]

    def _select_by_weights(self, pair: Sequence[float]) -> FloatArray:
        """Return one value per walker: `pair[0]` for several objectives, `pair[1]` for one."""
        return np.where(self._has_mixed_weights(), *pair)

    def _has_mixed_weights(self) -> BoolArray:
        return np.asarray(self.state.weights.max(axis=1) < 1)
