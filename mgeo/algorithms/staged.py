"""MGEOStaged: a search whose problem is judged more precisely, and at a higher cost, by stages."""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from pymoo.core.algorithm import Algorithm
from pymoo.core.population import Population
from pymoo.core.problem import Problem

from mgeo._typing import FloatArray
from mgeo.algorithms.archive import ParetoArchive
from mgeo.algorithms.directed import MGEODirected
from mgeo.algorithms.moves import DirectedState
from mgeo.evaluation.individuals import individuals
from mgeo.validation.arguments import validate_fraction, validate_list


@dataclass(kw_only=True, eq=False, slots=True)
class StagedState(DirectedState):
    """The state of a run of `MGEOStaged`.

    Attributes
    ----------
    stage : the present one, from 0.
    """

    stage: int


class MGEOStaged(MGEODirected):
    """`MGEODirected` in stages: first rough, at last as precise as the problem can.

    A problem whose values are estimates, from samples say, is cheap to search roughly and dear to
    search precisely. At the beginning of a stage all points of the archive are evaluated anew, the
    archive keeps what is nondominated then, and the walkers go on from its points. If a run ends
    before the last stage, the archive is evaluated as there.

    A problem that can be judged roughly has a method ``at_stage(k)``, which gives the problem as
    stage k of a search judges it, from 0; the last stage judges by the problem itself. For any
    other problem, and one whose ``at_stage(0)`` is the problem itself, it is `MGEODirected`.

    Parameters
    ----------
    stages : shares of the run, as its termination counts it, at which the second stage and those
        after it begin, ascending in [0, 1]. One that begins at 1 is no search, but a last judgment.
    options : the parameters of `MGEODirected`.

    Attributes
    ----------
    state : the `StagedState`.

    Raises
    ------
    TypeError, ValueError : for a parameter of the wrong type or out of range, or an unknown one.

    Examples
    --------
    >>> from pymoo.optimize import minimize
    >>> from pymoo.problems.multi import ZDT1
    >>> from mgeo import MGEOStaged
    >>> class Sampled(ZDT1):
    ...     samples = 64
    ...     def at_stage(self, k):
    ...         problem = Sampled(n_var=4)
    ...         problem.samples = (4, 16, 64)[k]
    ...         return problem
    >>> result = minimize(Sampled(n_var=4), MGEOStaged(), ("n_eval", 500), seed=1)
    >>> result.problem.samples
    64
    """

    state: StagedState
    #: Whether what is evaluated are points of the archive, anew: no new designs.
    judging = False
    #: Whether the run has ended with a judgment as in the last stage, which is no generation.
    concluded = False

    def __init__(self, stages: Sequence[float] = (0.87, 0.99, 1.0), **options: Any) -> None:
        self._whole: Problem | None = None
        self._judges: dict[int, Problem] = {}  # by stages
        super().__init__(**options)
        if not np.size(stages) or np.ndim(stages) != 1:
            raise ValueError(f"stages = {stages!r}: expected one or more numbers")
        self.stages = validate_list("stages", stages, validate_fraction)
        if self.stages != sorted(self.stages):
            raise ValueError(f"stages = {stages!r}: expected the earlier ones first")

    @property
    def stage(self) -> int:
        """The present stage, from 0."""
        return self.state.stage

    @property
    def problem(self) -> Problem | None:
        """The problem as the present stage judges it."""
        return self._whole if self.is_precise else self._judge(self.stage)

    @problem.setter
    def problem(self, whole: Problem | None) -> None:
        self._whole, self._judges = whole, {}

    @property
    def is_precise(self) -> bool:
        """Whether values are those of the last stage."""
        if self._whole is None or not hasattr(self, "state") or self.stage == len(self.stages):
            return True
        return self._judge(0) is self._whole

    def archived_designs(self) -> Any:
        """The points of the archive, as the problem takes them."""
        return self.variables.designs(self.archived(np.arange(len(self.front))))

    def conclude(self) -> None:
        """Judge the archive as in the last stage, if the run has not come that far."""
        if (self.is_precise and not self.judging) or not len(self.front):
            return
        self.state.stage = len(self.stages)
        self.judging = True
        population = self._archive()
        self.evaluator.eval(self.problem, population, algorithm=self)
        self._begin_stage(population)
        self.judging, self.concluded = False, True
        self.off = population
        self._set_optimum()

    def new_state(self, *parts: Any) -> StagedState:
        state = super().new_state(*parts)
        known = {field.name: getattr(state, field.name) for field in fields(state)}
        return StagedState(**known, stage=0)

    def _judge(self, stage: int) -> Problem:
        if stage not in self._judges:
            at_stage = getattr(self._whole, "at_stage", None)
            self._judges[stage] = self._whole if at_stage is None else at_stage(stage)
        return self._judges[stage]

    def _finalize(self) -> None:
        self.conclude()

    def _infill(self) -> Population:
        done, later = self.termination.perc, self.stages[self.stage :]
        if self.is_precise or done < later[0]:
            return super()._infill()
        self.state.stage += 1
        if not len(self.front):
            self.forget(np.arange(self.n_walkers))
            return super()._infill()
        self.judging = True
        return self._archive()

    def _advance(self, infills: Any = None, **kwargs: Any) -> None:
        if not self.judging:
            return super()._advance(infills, **kwargs)
        infills = self._in_asked_order(infills)
        self._begin_stage(infills)
        self.judging = False
        self.pop = infills
        self.state.n_generations = self.n_iter
        return None

    def _archive(self) -> Population:
        """The points of the archive, to be evaluated anew."""
        self._asked = self.archived_designs()
        return individuals(self._asked)

    def _begin_stage(self, judged: Population) -> None:
        """Let the archive be what is nondominated of these, and walkers go on from its points."""
        F, violation, _ = self._values(judged)
        state, walkers = self.state, np.arange(self.n_walkers)
        state.front = ParetoArchive(F.shape[1], self.archive_size)
        state.front.add(F, judged, violation)
        self.forget(walkers)
        self._migrate(walkers)
        marked: FloatArray = state.incumbent_F.copy()
        state.marked_F = marked
        self._asked = None


def is_rough(algorithm: Algorithm | None) -> bool:
    """Whether what an algorithm evaluates now are estimates, and not the values of its result."""
    return isinstance(algorithm, MGEOStaged) and not algorithm.is_precise
