"""Runs that are ready to be solved, from names and scenarios or made again."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from pymoo.core.algorithm import Algorithm
from pymoo.core.problem import Problem

from mgeo.plugins import protocol
from mgeo.plugins.problems import load_problem
from mgeo.runs.algorithms import (
    build_algorithm,
    complete_parameters,
    default_algorithm,
    default_evaluations,
)
from mgeo.runs.operators import with_suggested
from mgeo.runs.solve import State, follow, set_up
from mgeo.store.run import Notes, Outcome, RunConfiguration
from mgeo.validation.tables import checked

if TYPE_CHECKING:
    from mgeo.store.run_persistence import RunPersistence


@dataclass(frozen=True, eq=False)
class PreparedRun:
    """A configuration and what was built from it.

    It can be solved more than once, unless it has begun: ``notes`` then tell how it went.
    """

    configuration: RunConfiguration
    problem: Problem
    algorithm: Algorithm
    notes: Notes | None = None

    @classmethod
    def of(cls, configuration: RunConfiguration) -> PreparedRun:
        """Build the problem and the algorithm.

        Raises
        ------
        ValueError, TypeError
            If a name, an option or a parameter is refused.
        """
        problem = load_problem(configuration.problem, configuration.options)
        algorithm = build_algorithm(configuration.algorithm, configuration.parameters, problem)
        run = cls(configuration, problem, algorithm)
        run.check()
        return run

    def solve(
        self,
        callback: Callable[[State], object] | None = None,
        persistence: RunPersistence | None = None,
        max_time: float | None = None,
    ) -> Outcome:
        """Run the algorithm until its budget is used (see `mgeo.runs.solve.follow`)."""
        run = self.configuration
        algorithm = self.algorithm
        if self.notes is None:
            algorithm = self._set_up(run.starts)
        return follow(
            self.problem,
            algorithm,
            run.evaluations,
            callback,
            persistence,
            self.notes,
            polish=run.polish,
            max_time=max_time,
        )

    def check(self) -> None:
        """Refuse what could not be run, before anything is evaluated or suggested.

        Raises
        ------
        ValueError
            If a part of it is refused.
        """
        run = self.configuration
        self._set_up()
        if run.starts:
            with_suggested(self.algorithm, run.starts)
            if not protocol.is_own(self.problem, protocol.ProblemMixin.starts):
                raise ValueError(
                    f"{run.problem} suggests no designs to begin with: expected starts = 0"
                )
        if run.polish:  # a problem refuses of none what it would refuse of any
            for _ in protocol.refinement(self.problem, np.empty((0, self.problem.n_var))):
                pass

    def _set_up(self, starts: int = 0) -> Algorithm:
        run = self.configuration
        protocol.column_names(self.problem)  # wrong ones are refused before anything is evaluated
        return set_up(self.problem, self.algorithm, run.evaluations, run.seed, starts)


def prepare(
    problem: str,
    options: Mapping[str, Any] | None = None,
    *,
    algorithm: str | None = None,
    parameters: Mapping[str, Any] | None = None,
    evaluations: int | None = None,
    seed: int = 1,
    robust: bool = False,
    starts: int | None = 0,
    polish: bool | None = False,
) -> PreparedRun:
    """A new run whose configuration leaves nothing to defaults that may change.

    The problem's own ``options()`` are written out, the algorithm's parameters completed; without
    an algorithm it is the `default_algorithm`, and the budget is `default_evaluations` if none is
    given. A `robust` run is one of the problem that this problem's ``robust()`` gives. It begins
    with `starts` of the problem's suggestions and ends, with `polish`, with the problem's
    refinement. None of these is what the problem recommends, as is the budget of a run that has its
    polish so; of one that is `robust`, or whose algorithm, its parameters or budget are given,
    nothing is recommended.

    Raises
    ------
    ValueError, TypeError
        If a name, an option or a parameter is refused, or the options are no JSON values.
    """
    plain = not (robust or algorithm or parameters or evaluations)
    algorithm = algorithm or default_algorithm(robust)
    complete = complete_parameters(algorithm, parameters or {})
    built = load_problem(problem, options, named=(problem,))
    if robust:
        built = protocol.robust(built)
    optimizer = build_algorithm(algorithm, complete, built)
    own = protocol.options(built)
    advised = protocol.recommended(built) if plain else protocol.Recommended()
    starts = advised.starts if starts is None else starts
    if polish is None:
        polish, evaluations = advised.polish, evaluations or advised.evaluations
    if evaluations is None:
        evaluations = default_evaluations(optimizer, built)
    data = {
        "problem": problem,
        "options": dict(options or {}) if own is None else own,
        "algorithm": algorithm,
        "parameters": complete,
        "evaluations": evaluations,
        "seed": seed,
        "starts": starts,
        "polish": polish,
    }
    try:  # as a file gives it, so that a run made now and one made again are the same
        data = json.loads(json.dumps(data, allow_nan=False))
    except (TypeError, ValueError) as error:
        raise ValueError(f"the options of {problem!r} are no JSON values: {error}") from error
    run = PreparedRun(checked(RunConfiguration, data), built, optimizer)
    run.check()
    return run
