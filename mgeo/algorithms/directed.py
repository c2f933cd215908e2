"""MGEODirected: walkers that head each for its own part of the front, and learn from the others."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from pymoo.core.problem import Problem

from mgeo._typing import BoolArray, FloatArray, IntArray
from mgeo.algorithms.archive import ParetoArchive
from mgeo.algorithms.base import ExtremalOptimization
from mgeo.algorithms.bounds import BOUNDS
from mgeo.algorithms.coding import RealCode
from mgeo.algorithms.run_state import RunState
from mgeo.algorithms.selection import pick, rank
from mgeo.algorithms.steps import (
    Attraction,
    joint_steps,
    momentum_steps,
    whole_steps,
    within_a_step,
)
from mgeo.algorithms.variables import KINDS, Variables
from mgeo.algorithms.weights import (
    distance,
    nearest,
    nearest_drawn,
    random_weights,
    weight_vectors,
)
from mgeo.validation.arguments import (
    validate_ascending,
    validate_choice,
    validate_fraction,
    validate_integer,
    validate_number,
    validate_pair,
)

_PROGRESS = 0.1  # over the points of the front: the share of its extent that is progress


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
    marked_F : (n_walkers, n_obj) objectives of the incumbent at its last progress, likewise;
        `idle` counts the generations since then.
    """

    weights: FloatArray
    incumbents: FloatArray
    momentum: FloatArray
    incumbent_F: FloatArray
    incumbent_violation: FloatArray
    marked_F: FloatArray


class MGEODirected(ExtremalOptimization):
    """Extremal optimization by walkers that head each for its own part of the front.

    As in MGEO_real, a walker tries a change of each of some variables, ranks what comes out, and
    accepts the change of rank k with a probability proportional to k^-tau, be it better or not.
    Four things are different:

    - **A goal of its own.** A walker ranks by the distance along its weight vector (weighted
      Tchebycheff, scaled by the front found so far). A share of them has extreme weights, of one
      objective alone; the others are spread between these extremes.
    - **Three kinds of candidates.** Momentum: on as the step that led to the walker's best point,
      and towards a point of the archive, in all variables (a particle swarm's move; Zhang et al.
      2018). Difference: by a fraction of that between two points of the archive or bests of
      walkers, in many variables (differential evolution's; Storn & Price 1997). Or a normal step,
      mostly of one variable.
    - **Return.** After most generations a walker goes back to its best point, or, more rarely, to
      the archive's nearest along its weight vector.
    - **Restart.** Without progress it begins anew: with other weights, or, where it minimizes one
      objective alone and local optima are many, at a random point.

    Variables are real, or, with `Problem(vars=...)`, integers, bits and choices beside them: steps
    are rounded then, and a choice takes the option of a donor (`mgeo.algorithms.steps`). A
    generation costs n_walkers x min(n_var, max_candidates) evaluations; nothing depends on the
    termination. With one objective all walkers minimize it.

    Parameters
    ----------
    tau : selection pressure, >= 0.
    n_walkers : number of walkers.
    extreme_weights : share of the walkers that minimize one objective alone, in [0, 1].
    difference : shares of the candidates made by differences, of those without momentum, in
        [0, 1]. Of this pair and others, the first is for walkers between the extremes, the second
        for those at them, unless it says otherwise.
    coupling : mean probabilities that a normal step, and that a difference, changes also each of
        the other variables; each candidate draws its own (`joint_steps`).
    widths : smallest and largest standard deviation of normal steps, of the bounds' width.
    return_to_best : probability a generation that a walker returns to its best point.
    migrate : probabilities a generation that it goes to the archive's nearest point instead; rare
        at the extremes, where each walker may have a local optimum of its own.
    restart : generations without progress after which a walker restarts, >= 1.
    max_candidates : largest number of candidates a walker; of more variables they are drawn.
    bounds : what becomes of a step that leaves them: "clip" to the bound, "reflect" from it, or
        "resample", drawn anew until it stays inside (`mgeo.algorithms.bounds`).
    attract : share of the differences that move also towards the archive's nearest point, and the
        mean probability that these change each of the other variables.
    momentum : shares of the candidates with momentum, in [0, 1] (`momentum_steps`); at the
        extremes only where the point that they are drawn to is within a step.
    targets : share of the steps with momentum that is drawn to the nearest of all archived points,
        and c >= 0: the others to the nearest of c sqrt(n) random ones of n, and of one at least.
    progress : smallest and largest share of the front's extent by which a best point must come
        nearer, to count as progress; between them it is 0.1 / n.
    options : `sampling` and `archive_size` of `mgeo.algorithms.base.ExtremalOptimization`, and
        those of every pymoo algorithm: `termination` (5000 // n_walkers generations unless
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
        n_walkers: int = 16,
        extreme_weights: float = 0.4,
        difference: Sequence[float] = (0.2, 0.65),
        coupling: Sequence[float] = (0.05, 0.5),
        widths: Sequence[float] = (1e-3, 1.0),
        return_to_best: float = 0.7,
        migrate: Sequence[float] = (0.2, 0.02),
        restart: Sequence[int] = (4, 50),
        max_candidates: int = 3,
        bounds: str = "clip",
        attract: Sequence[float] = (0.5, 0.9),
        momentum: Sequence[float] = (0.6, 0.6),
        targets: Sequence[float] = (0.3, 0.33),
        progress: Sequence[float] = (1e-5, 1e-3),
        **options: Any,
    ) -> None:
        super().__init__(tau=validate_number("tau", tau, low=0), n_walkers=n_walkers, **options)
        self.extreme_weights = validate_fraction("extreme_weights", extreme_weights)
        self.difference = validate_pair("difference", difference, validate_fraction)
        self.coupling = validate_pair("coupling", coupling, validate_fraction)
        self.attract = validate_pair("attract", attract, validate_fraction)
        self.momentum = validate_pair("momentum", momentum, validate_fraction)
        self.widths = validate_ascending("widths", widths, above=0)
        self.progress = validate_ascending("progress", progress, above=0)
        self.targets = validate_pair("targets", targets, validate_number, low=0)
        validate_fraction("targets[0]", self.targets[0])
        self.return_to_best = validate_fraction("return_to_best", return_to_best)
        self.migrate = validate_pair("migrate", migrate, validate_fraction)
        if self.return_to_best + max(self.migrate) > 1:
            raise ValueError(
                f"return_to_best = {return_to_best!r}, migrate = {migrate!r}: expected sums of at "
                "most 1"
            )
        self.restart = validate_pair("restart", restart, validate_integer, low=1)
        self.max_candidates = validate_integer("max_candidates", max_candidates, low=1)
        self.bounds = validate_choice("bounds", bounds, BOUNDS)

    def representation(self, problem: Problem) -> RealCode:
        return RealCode(Variables.of(problem, KINDS))

    def new_state(
        self, streams: list[np.random.Generator], front: ParetoArchive, walkers: FloatArray
    ) -> DirectedState:
        n, n_obj = len(walkers), front.F.shape[1]
        return DirectedState.begin(
            streams,
            front,
            walkers,
            weights=weight_vectors(n, n_obj, self.extreme_weights),
            incumbents=np.empty_like(walkers),
            momentum=np.empty_like(walkers),
            incumbent_F=np.empty((n, n_obj)),
            incumbent_violation=np.empty(n),
            marked_F=np.empty((n, n_obj)),
        )

    def forget(self, rows: IntArray) -> None:
        super().forget(rows)
        state = self.state
        state.incumbents[rows] = state.walkers[rows]
        state.momentum[rows] = 0.0
        state.incumbent_F[rows] = state.marked_F[rows] = np.inf
        state.incumbent_violation[rows] = np.inf

    def candidates(self) -> FloatArray:
        xl, xu = self.variables.xl, self.variables.xu
        own = np.broadcast_to(np.arange(len(xl)), (self.n_walkers, len(xl)))
        if len(xl) > self.max_candidates:
            own = self.random_state.permuted(own, axis=1)[:, : self.max_candidates]
        donors = attraction = None
        if len(self.front):
            donors, aims = self._donors, self.archived(self._nearest())
            share, coupling = self.attract
            if share:
                attraction = Attraction(share, coupling, self.walkers[:, None], aims[:, None])
        steps, spread, donor = joint_steps(
            own, xu - xl, self.widths, self.coupling, self._of_kind(self.difference)[:, None],
            donors, self.random_state, attraction,
        )  # fmt: skip
        if donor is not None and any(self.momentum):
            self._go_on(steps, spread, donor, aims)
        walkers, uniform = self.walkers[:, None, :], partial(self.random_state.random, steps.shape)
        self.proposed = BOUNDS[self.bounds](walkers, steps, spread, xl, xu, uniform)
        whole = ~self.variables.real
        if whole.any():
            learned = np.full(steps.shape, np.nan) if donor is None else donor
            learned = np.where((spread == 0.0).all(axis=-1, keepdims=True), learned, np.nan)
            ended = whole_steps(
                walkers, self.proposed, own, learned, self.variables.choice, xl, xu, uniform()
            )
            self.proposed = np.where(whole, ended, self.proposed)
        return self.proposed.reshape(-1, len(xl))

    def _go_on(
        self, steps: FloatArray, spread: FloatArray, donor: FloatArray, aims: FloatArray
    ) -> None:
        """Put steps with momentum in the place of some; `aims` are the nearest archived points."""
        rng, state = self.random_state, self.state
        made = rng.random(steps.shape[:2]) < self._of_kind(self.momentum)[:, None]
        rows, columns = np.nonzero(made)
        if not len(rows):
            return
        share, few = self.targets
        n_drawn = max(1, int(few * len(self.front) ** 0.5))
        drawn = rng.integers(len(self.front), size=(len(rows), n_drawn))
        aimed = nearest_drawn(drawn, self.front.F, state.weights[rows], *state.front.ends)
        targets = np.where(rng.random((len(rows), 1)) < share, aims[rows], self.archived(aimed))
        x, choice = self.walkers[rows], self.variables.choice  # options have no order
        extent = self.variables.xu - self.variables.xl
        near = within_a_step(x, np.where(choice, x, targets), extent) | self._between()[rows]
        made[rows[~near], columns[~near]] = False
        rows, targets = rows[near], targets[near]
        before = np.where(choice, 0.0, state.momentum[rows])
        steps[made] = momentum_steps(x[near], before, targets, extent, rng)
        spread[made], donor[made] = 0.0, targets

    def _nearest(self, rows: IntArray | slice = slice(None)) -> IntArray:
        """Which of the archive's points are nearest along the weight vectors of walkers."""
        state, F = self.state, self.state.front.F
        return nearest(F, state.weights[rows], *state.front.ends)

    def _donors(self, shape: tuple[int, ...]) -> tuple[FloatArray, FloatArray]:
        """Twice (..., n_var) points of the donor pool."""
        rng, n = self.random_state, len(self.front)
        donors = []
        for _ in range(2):
            archived = rng.integers(n, size=shape)
            incumbents = self.state.incumbents[rng.integers(self.n_walkers, size=shape)]
            of_archive = rng.random((*shape, 1)) < 0.5
            known = self.archived(archived.ravel()).reshape(incumbents.shape)
            donors.append(np.where(of_archive, known, incumbents))
        return donors[0], donors[1]

    def accept(self, F: FloatArray, violation: FloatArray) -> BoolArray:
        state, rng, walker = self.state, self.random_state, np.arange(self.n_walkers)
        F = F.reshape(self.n_walkers, -1, F.shape[1])
        violation = np.where(np.isfinite(F).all(axis=2), violation.reshape(F.shape[:2]), np.inf)
        far = distance(F, state.weights[:, None], *state.front.ends)
        ranking = rank(far, violation, rng.random(far.shape))
        place = pick(rng.random(self.n_walkers), F.shape[1], float(self.tau))
        best = walker, ranking[:, 0]
        less = self._improve(self.proposed[best], F[best], violation[best], far[best])
        state.walkers = self.proposed[walker, ranking[walker, place]]
        self._go_back()
        return less

    def _improve(
        self, points: FloatArray, F: FloatArray, violation: FloatArray, far: FloatArray
    ) -> BoolArray:
        """Update the incumbents; tells whose constraint violation is less than ever."""
        state = self.state
        before = distance(state.incumbent_F, state.weights, *state.front.ends)
        less = violation < state.incumbent_violation
        feasible = (violation == 0) & (state.incumbent_violation == 0)
        better = less | (feasible & (far < before))
        state.momentum[better] = points[better] - state.walkers[better]
        state.incumbents[better] = points[better]
        state.incumbent_F[better] = F[better]
        state.incumbent_violation[better] = violation[better]
        return np.asarray(less)

    def _go_back(self) -> None:
        """Let some walkers return to their incumbents, and some migrate to the archive."""
        state, chance = self.state, self.random_state.random(self.n_walkers)
        returns = (chance < self.return_to_best) & np.isfinite(state.incumbent_violation)
        state.walkers[returns] = state.incumbents[returns]
        migrate = self.return_to_best + self._of_kind(self.migrate)
        self._migrate(np.flatnonzero((chance >= self.return_to_best) & (chance < migrate)))

    def _migrate(self, rows: IntArray) -> None:
        """Put walkers on the archive's points nearest along their weight vectors."""
        state, front = self.state, self.state.front
        if not len(rows) or not len(front):
            return
        nearest = self._nearest(rows)
        points = self.archived(nearest)
        state.momentum[rows] = points - state.walkers[rows]
        state.walkers[rows] = state.incumbents[rows] = points
        state.incumbent_F[rows] = front.F[nearest]
        state.incumbent_violation[rows] = front.violation

    def restart_idle(self, progress: BoolArray, entered: BoolArray) -> None:
        # progress is less violation, or a feasible incumbent that has come nearer by enough
        state = self.state
        ideal, nadir = state.front.ends
        far, before = (
            distance(F, state.weights, ideal, nadir) for F in (state.incumbent_F, state.marked_F)
        )
        # the nearer the front's points are to each other, the less there is to come nearer by
        smallest, largest = self.progress
        share = min(max(_PROGRESS / max(len(state.front), 1), smallest), largest)
        least = share if (ideal < nadir).all() else 0.0  # one objective has no extent
        feasible = state.incumbent_violation == 0
        nearer = feasible & ~(far >= before - least)  # true where nothing is marked yet
        state.marked_F[nearer] = state.incumbent_F[nearer]
        state.idle = np.where(nearer | progress, 0, state.idle + 1)
        between = self._between()
        idle = state.idle >= self._of_kind(self.restart)
        if len(rows := np.flatnonzero(idle & between)) and len(state.front):
            state.weights[rows] = random_weights(
                len(rows), state.weights.shape[1], self.random_state
            )
            self._migrate(rows)
            state.marked_F[rows] = state.incumbent_F[rows]
            state.idle[rows] = 0
        if len(rows := np.flatnonzero(idle & ~between)):
            self.restart_walkers(rows)

    def _of_kind(self, pair: Sequence[float]) -> FloatArray:
        """(n_walkers,) the first of two numbers for walkers between the extremes, or the second."""
        return np.where(self._between(), *pair)

    def _between(self) -> BoolArray:
        """(n_walkers,) which walkers have weights of several objectives."""
        return np.asarray(self.state.weights.max(axis=1) < 1)
