"""Candidates of `MGEODirected`: recombination, momentum, differences, normal steps."""

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
from mgeo.algorithms.recombination import Credit, recombine
from mgeo.algorithms.run_state import RunState
from mgeo.algorithms.selection import build_weight_vectors, find_nearest, find_nearest_in_sample
from mgeo.algorithms.steps import NORMAL, get_bounding, round_steps
from mgeo.algorithms.variables import KINDS, Variables

Pair = tuple[float, float]
Donors = Callable[[tuple[int, ...]], tuple[FloatArray, FloatArray]]


class Attraction(NamedTuple):
    """A pull towards the best that is known: differential evolution's current-to-best move.

    As in Zhang & Sanderson, "JADE" (IEEE Trans. Evol. Comput. 13, 2009), equation 6, but a step
    goes a fraction of the way that is uniform in [0, 1).

    Attributes
    ----------
    share : of the steps that are differences, those that are pulled as well.
    coupling : mean probability that such a step changes another variable.
    start : (..., n_var) where steps begin.
    target : (..., n_var) what they are pulled to.
    """

    share: float
    coupling: float
    start: FloatArray
    target: FloatArray


#: Of steps with momentum: the largest fraction of the step before, and the largest step of a
#: variable as a fraction of the width of its bounds.
_MAX_INERTIA, _MAX_STEP = 1.2, 0.2


def draw_momentum_steps(
    x: FloatArray,
    previous_steps: FloatArray,
    targets: FloatArray,
    extent: FloatArray,
    rng: np.random.Generator,
) -> FloatArray:
    """Steps of all variables that go on as the step before, and towards a target: a swarm's move.

    r1 before + r2 (target - x), with r1 and r2 uniform and of each variable its own (Zhang et al.,
    "A competitive mechanism based multi-objective particle swarm optimizer with fast convergence",
    Information Sciences 427, 2018, equation 3). What is remembered here is a step that was good.

    Parameters
    ----------
    x : (..., n_var) where steps begin.
    previous_steps : (..., n_var) the steps before; they broadcast.
    targets : (..., n_var) what they are drawn to; they broadcast.
    extent : (n_var,) width of the bounds.
    rng : stream of random numbers.

    Returns
    -------
    (..., n_var) steps.
    """
    way = targets - x
    step = _MAX_INERTIA * rng.random(way.shape) * previous_steps + rng.random(way.shape) * way
    return np.clip(step, -_MAX_STEP * extent, _MAX_STEP * extent)


def is_within_step(x: FloatArray, targets: FloatArray, extent: FloatArray) -> BoolArray:
    """Which targets, (..., n_var), one step with momentum can reach in every variable."""
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
    """Steps that change each its own variable, and others with some probability.

    Parameters
    ----------
    primary : (...) the variable of each step.
    extent : (n_var,) width of the bounds.
    sigma_range : smallest and largest standard deviation of a normal step, as a fraction of `extent`;
        that of each step is log-uniform between them.
    coupling : mean probability that another variable changes: of normal steps, and of
        differences. Each step has its own, u^(1/mean - 1) with u uniform in [0, 1): some steps
        change hardly any other variable, some nearly all, whatever the problem may need.
    difference_share : share, or shares that broadcast with `primary`, of the steps that are a fraction,
        uniform in [0, 1), of the difference between two points (differential evolution's move;
        Storn & Price 1997).
    donors : gives as many pairs of points, (..., n_var) each, as it is asked for; None for normal
        steps only.
    rng : stream of random numbers.
    attraction : moves some of the steps that are differences also towards points, if given.

    Returns
    -------
    (..., n_var) steps, zero where a variable stays; their standard deviations, zero where they are
    such a fraction; and the points towards which it is, if there are any: the first ones of the
    pairs, or those of the attraction.
    """
    shape = *primary.shape, len(extent)
    least, largest = np.log(sigma_range)
    width = np.exp(rng.uniform(least, largest, primary.shape))[..., None]
    spread = width * extent
    step = spread * rng.standard_normal(shape)
    mean = np.full(primary.shape, coupling[0])
    first = None
    if donors is not None:
        learns = rng.random(primary.shape) < difference_share
        first, second = donors(primary.shape)
        between = first - second
        step = np.where(learns[..., None], rng.random(primary.shape)[..., None] * between, step)
        spread[learns] = 0.0
        mean[learns] = coupling[1]
        if attraction is not None:
            pulled = learns & (rng.random(primary.shape) < attraction.share)
            part = rng.random(primary.shape)[..., None] * (attraction.target - attraction.start)
            step = np.where(pulled[..., None], step + part, step)
            mean[pulled] = attraction.coupling
            first = np.where(pulled[..., None], attraction.target, first)
    with np.errstate(divide="ignore"):  # of a mean of zero, for which every probability is zero
        chance = rng.random(primary.shape) ** (1.0 / mean - 1.0)
    changed = rng.random(shape) < chance[..., None]
    np.put_along_axis(changed, primary[..., None], True, axis=-1)
    return np.where(changed, step, 0.0), spread, first


@dataclass(kw_only=True, eq=False, slots=True)
class DirectedState(RunState):
    """The state of a run of `MGEODirected`.

    Attributes
    ----------
    weights : (n_walkers, n_obj) weight vectors of the walkers.
    incumbents : (n_walkers, n_var) the best point of each walker since it started.
    momentum : (n_walkers, n_var) the step that led to it; 0 while there is none.
    incumbent_F, incumbent_violation : its objectives, (n_walkers, n_obj), and constraint
        violation, (n_walkers,), infinite while there is none.
    reference_F : (n_walkers, n_obj) objectives of the incumbent at its last progress, likewise;
        `idle` counts the generations since then.
    distributions : the distributions of the walkers that learn a covariance.
    credit : the recent gains by recombination and by all other candidates.
    """

    weights: FloatArray
    incumbents: FloatArray
    momentum: FloatArray
    incumbent_F: FloatArray
    incumbent_violation: FloatArray
    reference_F: FloatArray
    distributions: SearchDistributions
    credit: Credit


class DirectedMoves(ExtremalOptimization):
    """The candidates of walkers that know their best point, and an archive.

    A subclass has the parameters `extreme_weights`, `difference`, `momentum`, `max_candidates` and
    `bounds`, and says what becomes of the candidates. The constants are what a search over them has
    found; docs/studies/results.md has what is lost without each. To have another one, derive a
    class.
    """

    #: Mean probabilities that a normal step, and that a difference, changes also each of the other
    #: variables (`draw_joint_steps`): half of a difference, lest it is a copy of what it comes from.
    coupling: ClassVar[Pair] = (0.05, 0.5)
    #: Smallest and largest standard deviation of normal steps, of the bounds' width: no scale is
    #: preferred, as none is known.
    sigma_range: ClassVar[Pair] = (1e-3, 1.0)
    #: Share of the differences that move also towards the archive's nearest point, and the mean
    #: probability that these change each of the other variables: nearly all, as valleys need.
    attraction: ClassVar[Pair] = (0.5, 0.9)
    #: Share of the steps with momentum that is drawn to the nearest of all archived points, and c:
    #: the others to the nearest of c sqrt(n) random ones of n, of one at least. The more points
    #: there are, the nearer they must be, or a walker is drawn along the front and not across it.
    target_selection: ClassVar[Pair] = (0.3, 0.33)
    #: Smallest and largest share of the candidates that recombine two points. Between them the
    #: share follows what such candidates gain (`recombination.Credit`).
    recombination: ClassVar[Pair] = (0.02, 0.9)
    #: Share of the walkers, of those between the extremes and of those at them, that learn a
    #: covariance of their own; after how many evaluations per variable: from 500 on, multimodal
    #: functions gain by 2,000, and unimodal ones lose a little; and of how many variables at most,
    #: as a larger matrix takes longer than runs are.
    adaptive_share: ClassVar[float] = 0.5
    adaptation_delay: ClassVar[int] = 2000
    max_adaptive_variables: ClassVar[int] = 100

    state: DirectedState
    extreme_weights: float
    difference: Sequence[float]
    momentum: Sequence[float]
    max_candidates: int
    bounds: str
    #: (n_walkers, candidates a walker) mask that `candidates` leaves for `accept`.
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
            credit=Credit.create(n * self._n_candidates),
        )

    def generate_candidates(self) -> FloatArray:
        xl, xu = self.variables.xl, self.variables.xu
        own = np.broadcast_to(np.arange(len(xl)), (self.n_walkers, len(xl)))
        if len(xl) > self.max_candidates:
            own = self.random_state.permuted(own, axis=1)[:, : self.max_candidates]
        donors = attraction = None
        if len(self.front):
            donors, aims = self._draw_donors, self.get_archived_points(self._find_nearest())
            share, coupling = self.attraction
            if share:
                attraction = Attraction(share, coupling, self.walkers[:, None], aims[:, None])
        steps, spread, donor = draw_joint_steps(
            own, xu - xl, self.sigma_range, self.coupling, self._select_by_weights(self.difference)[:, None],
            donors, self.random_state, attraction,
        )  # fmt: skip
        if donor is not None and any(self.momentum):
            self._apply_momentum(steps, spread, donor, aims)
        self.is_recombined = np.zeros(steps.shape[:2], dtype=np.bool_)
        if donor is not None and len(self.front) > 1 and any(self.recombination):
            self._recombine(steps, spread, donor, aims)
        if len(rows := self._select_adapting_walkers()):
            steps[rows] = (xu - xl) * self.state.distributions.draw_steps(
                self._n_candidates, self.random_state
            )
            spread[rows], self.is_recombined[rows] = 0.0, False
        walkers, uniform = self.walkers[:, None, :], partial(self.random_state.random, steps.shape)
        bounding = get_bounding(self.bounds, self.problem.n_eq_constr)
        self.proposals = bounding(walkers, steps, spread, xl, xu, uniform, NORMAL)
        whole = ~self.variables.is_real
        if whole.any():
            learned = np.full(steps.shape, np.nan) if donor is None else donor
            learned = np.where((spread == 0.0).all(axis=-1, keepdims=True), learned, np.nan)
            ended = round_steps(
                walkers, self.proposals, own, learned, self.variables.is_choice, xl, xu, uniform()
            )
            self.proposals = np.where(whole, ended, self.proposals)
        return self.proposals.reshape(-1, len(xl))

    def _apply_momentum(
        self, steps: FloatArray, spread: FloatArray, donor: FloatArray, nearest_points: FloatArray
    ) -> None:
        """Put steps with momentum in the place of some; `nearest_points` are the nearest archived points."""
        rng, state = self.random_state, self.state
        made = rng.random(steps.shape[:2]) < self._select_by_weights(self.momentum)[:, None]
        rows, columns = np.nonzero(made)
        if not len(rows):
            return
        share, few = self.target_selection
        aimed = self._find_nearest_in_sample(rows, few * len(self.front) ** 0.5)
        targets = np.where(
            rng.random((len(rows), 1)) < share,
            nearest_points[rows],
            self.get_archived_points(aimed),
        )
        x, choice = self.walkers[rows], self.variables.is_choice  # options have no order
        extent = self.variables.xu - self.variables.xl
        near = (
            is_within_step(x, np.where(choice, x, targets), extent)
            | self._has_mixed_weights()[rows]
        )
        made[rows[~near], columns[~near]] = False
        rows, targets = rows[near], targets[near]
        before = np.where(choice, 0.0, state.momentum[rows])
        steps[made] = draw_momentum_steps(x[near], before, targets, extent, rng)
        spread[made], donor[made] = 0.0, targets

    def _recombine(
        self, steps: FloatArray, spread: FloatArray, donor: FloatArray, nearest_points: FloatArray
    ) -> None:
        """Replace some steps by those to recombined points; `nearest_points` are the nearest archived points.

        Between the extremes the first parent is the walker's incumbent or its nearest archived
        point, the second one the nearest of sqrt(n) random ones of the n archived points. At the
        extremes, where each walker may have a local optimum of its own, the parents are the
        incumbents of the walker and of any walker.
        """
        rng, state, variables = self.random_state, self.state, self.variables
        made = rng.random(steps.shape[:2]) < state.credit.compute_share(*self.recombination)
        rows, _ = np.nonzero(made)
        if not len(rows):
            return
        between = self._has_mixed_weights()[rows, None]
        of_archive = between & (rng.random((len(rows), 1)) < 0.5)
        first = np.where(of_archive, nearest_points[rows], state.incumbents[rows])
        archived = self.get_archived_points(
            self._find_nearest_in_sample(rows, len(state.front) ** 0.5)
        )
        others = state.incumbents[rng.integers(self.n_walkers, size=len(rows))]
        second = np.where(between, archived, others)
        points = recombine(first, second, variables.xl, variables.xu, variables.is_choice, rng)
        steps[made] = points - self.walkers[rows]
        spread[made], donor[made] = 0.0, points
        self.is_recombined = made

    def _find_nearest(self, rows: IntArray | slice = slice(None)) -> IntArray:
        """Which of the archive's points are nearest along the weight vectors of walkers."""
        state, F = self.state, self.state.front.F
        return find_nearest(F, state.weights[rows], *state.front.ideal_and_nadir)

    def _find_nearest_in_sample(self, rows: IntArray, n_sampled: float) -> IntArray:
        """Which of so many random points of the archive, one at least, are nearest likewise."""
        front = self.state.front
        size = len(rows), max(1, int(n_sampled))
        drawn = self.random_state.integers(len(front), size=size)
        return find_nearest_in_sample(
            drawn, front.F, self.state.weights[rows], *front.ideal_and_nadir
        )

    def _draw_donors(self, shape: tuple[int, ...]) -> tuple[FloatArray, FloatArray]:
        """Twice (..., n_var) points of the donor pool."""
        rng, n = self.random_state, len(self.front)
        donors = []
        for _ in range(2):
            archived = rng.integers(n, size=shape)
            incumbents = self.state.incumbents[rng.integers(self.n_walkers, size=shape)]
            of_archive = rng.random((*shape, 1)) < 0.5
            known = self.get_archived_points(archived.ravel()).reshape(incumbents.shape)
            donors.append(np.where(of_archive, known, incumbents))
        return donors[0], donors[1]

    @property
    def _n_candidates(self) -> int:
        """Candidates of a walker and generation."""
        return min(len(self.variables.xl), self.max_candidates)

    def _select_adaptive_walkers(self, weights: FloatArray) -> IntArray:
        """The walkers that learn a covariance in the end: of each kind the last ones."""
        if not self.variables.is_real.all() or len(self.variables.xl) > self.max_adaptive_variables:
            return np.empty(0, dtype=np.intp)
        between = weights.max(axis=1) < 1
        kinds = np.flatnonzero(between), np.flatnonzero(~between)
        return np.concatenate(
            [rows[len(rows) - round(self.adaptive_share * len(rows)) :] for rows in kinds]
        )

    def _select_adapting_walkers(self) -> IntArray:
        """The walkers that learn a covariance now: all that ever do, or none."""
        learners = self._select_adaptive_walkers(self.state.weights)
        return learners[self.state.distributions.sigma > 0]

    def _select_by_weights(self, pair: Sequence[float]) -> FloatArray:
        """(n_walkers,) the first of two numbers for walkers between the extremes, or the second."""
        return np.where(self._has_mixed_weights(), *pair)

    def _has_mixed_weights(self) -> BoolArray:
        """(n_walkers,) which walkers have weights of several objectives."""
        return np.asarray(self.state.weights.max(axis=1) < 1)
