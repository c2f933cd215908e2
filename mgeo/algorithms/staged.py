"""MGEOStaged, a search that increases the fidelity of the evaluations during the run."""

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
from mgeo.evaluation.individuals import build_population
from mgeo.validation.arguments import validate_fraction, validate_list


@dataclass(kw_only=True, eq=False, slots=True)
class StagedState(DirectedState):
    """State of an `MGEOStaged` run between two generations.

    Attributes
    ----------
    fidelity : int
        Current fidelity level, 0 being the lowest.
    """

    fidelity: int


class MGEOStaged(MGEODirected):
    """Variant of `MGEODirected` that starts at low fidelity and ends at full fidelity.

    The algorithm suits problems whose objectives are estimates, for example Monte Carlo averages.
    Fidelity and cost of the evaluations increase in steps during the run. At each increase, all
    archived points are evaluated again, the archive is rebuilt from the new values, and the walkers
    continue from archived points. If a run ends before the last increase, the archive is evaluated
    at full fidelity.

    The problem defines a method ``at_fidelity(k)`` that returns the problem at the fidelity level
    k, from 0. The highest level uses the problem itself. If a problem has no such method, or
    ``at_fidelity(0)`` returns the problem itself, the algorithm is identical to `MGEODirected`.

    Parameters
    ----------
    fidelity_schedule : fractions of the run at which the fidelity level increases by 1, ascending
        in [0, 1]. A last value of 1 evaluates the final archive at full fidelity without further
        search.
    options : parameters of `MGEODirected`.

    Attributes
    ----------
    state : StagedState
        Data that persist between generations.

    Raises
    ------
    TypeError, ValueError
        If a parameter is unknown, has the wrong type or is out of range.

    Examples
    --------
    >>> from pymoo.optimize import minimize
    >>> from pymoo.problems.multi import ZDT1
    >>> from mgeo import MGEOStaged
    >>> class Sampled(ZDT1):
    ...     samples = 64
    ...     def at_fidelity(self, k):
    ...         problem = Sampled(n_var=4)
    ...         problem.samples = (4, 16, 64)[k]
    ...         return problem
    >>> result = minimize(Sampled(n_var=4), MGEOStaged(), ("n_eval", 500), seed=1)
    >>> result.problem.samples
    64
    """

    state: StagedState
    #: True while archived points are evaluated again, instead of new candidates.
    is_reevaluating = False
    #: True after `evaluate_archive` has evaluated the archive at full fidelity. The evaluation does
    #: not count as a generation.
    is_archive_evaluated = False

    def __init__(
        self, fidelity_schedule: Sequence[float] = (0.87, 0.99, 1.0), **options: Any
    ) -> None:
        self._full_problem: Problem | None = None
        self._problems: dict[int, Problem] = {}  # Problems by fidelity level.
        super().__init__(**options)
        if not np.size(fidelity_schedule) or np.ndim(fidelity_schedule) != 1:
            raise ValueError(
                f"fidelity_schedule = {fidelity_schedule!r}: expected one or more numbers"
            )
        self.fidelity_schedule = validate_list(
            "fidelity_schedule", fidelity_schedule, validate_fraction
        )
        if self.fidelity_schedule != sorted(self.fidelity_schedule):
            raise ValueError(
                f"fidelity_schedule = {fidelity_schedule!r}: expected ascending numbers"
            )

    @property
    def fidelity(self) -> int:
        """Current fidelity level, where 0 is the lowest."""
        return self.state.fidelity

    @property
    def problem(self) -> Problem | None:
        """Problem at the current fidelity level."""
        return self._full_problem if self.is_full_fidelity else self._get_problem(self.fidelity)

    @problem.setter
    def problem(self, full_problem: Problem | None) -> None:
        self._full_problem, self._problems = full_problem, {}

    @property
    def is_full_fidelity(self) -> bool:
        """True if the algorithm currently evaluates at full fidelity."""
        full_problem = self._full_problem
        if (
            full_problem is None
            or not hasattr(self, "state")
            or self.fidelity == len(self.fidelity_schedule)
        ):
            return True
        return self._get_problem(0) is full_problem

    def get_archived_designs(self) -> Any:
        """Return the archived points as designs that the problem can evaluate."""
        return self.variables.to_designs(self.get_archived_points(np.arange(len(self.front))))

    def evaluate_archive(self) -> None:
        """Reevaluate the archive at full fidelity if the run ended at a lower fidelity.

        The archive is then rebuilt from the new values.
        """
        if (self.is_full_fidelity and not self.is_reevaluating) or not len(self.front):
            return
        self.state.fidelity = len(self.fidelity_schedule)
        self.is_reevaluating = True
        population = self._build_archive_population()
        self.evaluator.eval(self.problem, population, algorithm=self)
        self._rebuild_archive(population)
        self.is_reevaluating, self.is_archive_evaluated = False, True
        self.off = population
        self._set_optimum()

    def create_state(self, *parts: Any) -> StagedState:
        state = super().create_state(*parts)
        values = {field.name: getattr(state, field.name) for field in fields(state)}
        return StagedState(**values, fidelity=0)

    def _get_problem(self, fidelity: int) -> Problem:
        if fidelity not in self._problems:
            at_fidelity = getattr(self._full_problem, "at_fidelity", None)
            self._problems[fidelity] = (
                self._full_problem if at_fidelity is None else at_fidelity(fidelity)
            )
        return self._problems[fidelity]

    def _finalize(self) -> None:
        self.evaluate_archive()

    def _infill(self) -> Population:
        progress, remaining = self.termination.perc, self.fidelity_schedule[self.fidelity :]
        if self.is_full_fidelity or progress < remaining[0]:
            return super()._infill()
        self.state.fidelity += 1
        if not len(self.front):
            self.reset_walkers(np.arange(self.n_walkers))
            return super()._infill()
        self.is_reevaluating = True
        return self._build_archive_population()

    def _advance(self, infills: Any = None, **kwargs: Any) -> None:
        if not self.is_reevaluating:
            return super()._advance(infills, **kwargs)
        infills = self._restore_ask_order(infills)
        self._rebuild_archive(infills)
        self.is_reevaluating = False
        self.pop = infills
        self.state.n_generations = self.n_iter
        return None

    def _build_archive_population(self) -> Population:
        self._pending_designs = self.get_archived_designs()
        return build_population(self._pending_designs)

    def _rebuild_archive(self, population: Population) -> None:
        """Rebuild the archive from a population, and move all walkers to archived points."""
        F, violation, _ = self._get_objectives_and_violations(population)
        state, walkers = self.state, np.arange(self.n_walkers)
        state.front = ParetoArchive(F.shape[1], self.archive_size)
        state.front.add(F, population, violation)
        self.reset_walkers(walkers)
        self._migrate(walkers)
        reference_F: FloatArray = state.incumbent_F.copy()
        state.reference_F = reference_F
        self._pending_designs = None


def is_low_fidelity(algorithm: Algorithm | None) -> bool:
    """Return True if the current evaluations of an algorithm are below full fidelity."""
    return isinstance(algorithm, MGEOStaged) and not algorithm.is_full_fidelity
