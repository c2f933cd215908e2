"""Runs that are ready to be solved, from names and scenarios or made again, and their time."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Collection, Mapping
from contextlib import closing
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from pymoo.core.algorithm import Algorithm
from pymoo.core.problem import Problem

from mgeo._typing import FloatArray
from mgeo.algorithms.staged import MGEOStaged
from mgeo.evaluation.individuals import as_numbers
from mgeo.plugins import protocol
from mgeo.plugins.problems import load_problem, read_files
from mgeo.plugins.protocol import refinement, refinement_steps
from mgeo.runs.algorithms import (
    build_algorithm,
    complete_parameters,
    default_algorithm,
    default_evaluations,
)
from mgeo.runs.operators import with_suggested
from mgeo.runs.solve import State, follow, set_up
from mgeo.store.reading import parse_json, parse_toml, read_text
from mgeo.store.run import Notes, Outcome, RunConfiguration
from mgeo.validation.tables import checked, errors_of

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
    ) -> Outcome:
        """Run it to the end of its budget (see `mgeo.runs.solve.follow`)."""
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
            if getattr(self.problem, "starts", None) is None:
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


@dataclass(frozen=True)
class RunTime:
    """Times in seconds: elapsed, and of the processors (more, where several work).

    They were measured on `timed` evaluations. Of the elapsed time `polish` is that of a
    refinement, None where its problem does not say how long it will be.
    """

    elapsed: float
    processor: float
    timed: int
    polish: float | None = 0.0


def estimate(
    problem: Problem, algorithm: Algorithm, evaluations: int, seed: int, polish: bool = False
) -> RunTime:
    """Make two generations of a run, and think of the second as typical.

    The first, in which much is done for the first time, counts once. Of a staged search the second
    one's candidates tell what a later stage takes. Of a `polish` the first step is made, with what
    was found, and all are as long as the problem says. Whatever the run makes is forgotten.

    Raises
    ------
    ValueError
        As `mgeo.runs.solve.set_up`.
    """
    run = set_up(problem, algorithm, evaluations, seed)
    total = _time(run.next)
    first = run.evaluator.n_eval
    second = _time(run.next) if run.has_next() else total
    made = run.evaluator.n_eval
    ends = [*run.stages, 1.0] if isinstance(run, MGEOStaged) and not run.is_precise else [1.0]
    left = max(0.0, ends[0] * evaluations - first)
    total = total + left * second / max(1, made - first)
    for stage, (begin, end) in enumerate(pairwise(ends), 1):
        run.state.stage = stage
        judged = len(run.front) + (end - begin) * evaluations  # the front anew as it begins
        total = total + judged * _time_of_a_design(run)
    refined = _time_of_polish(problem, run.pop.get("X")) if polish else np.zeros(2)
    elapsed, processor = (total + (0.0 if refined is None else refined)).tolist()
    return RunTime(elapsed, processor, made, None if refined is None else float(refined[0]))


def _time_of_polish(problem: Problem, X: FloatArray) -> FloatArray | None:
    designs = as_numbers(problem, X).astype(float)
    steps = refinement_steps(problem, designs)
    if not steps:
        return None
    with closing(refinement(problem, designs)) as tables:
        return steps * _time(lambda: next(tables, None))


def _time_of_a_design(run: Algorithm) -> FloatArray:
    problem, X = run.problem, run.pop.get("X")
    problem.evaluate(X[:1], algorithm=run)  # much is done for the first time
    return _time(lambda: problem.evaluate(X, algorithm=run)) / len(X)


def _time(work: Callable[[], object]) -> FloatArray:
    """Elapsed time, and that of the processors."""
    start = _clocks()
    work()
    return np.subtract(_clocks(), start)


def _clocks() -> tuple[float, float]:
    return time.perf_counter(), time.process_time()


#: Largest result to go on from [bytes].
MOST_BYTES = 50_000_000


def read_scenario(
    problem: str,
    text: str | None,
    folder: Path | str = "",
    after: Path | None = None,
    *,
    named: Collection[str] = (),
) -> dict[str, Any]:
    """Options of a problem from what was given: nothing, ``FILE.toml`` or a preset's name.

    A file's name is relative to `folder`; what it names itself is relative to its own folder, and
    is read by the problem, one of those `named` if that is ``module:Class`` (see
    `mgeo.plugins.problems.load_problem`). What the JSON file `after` holds becomes the option of
    this name.

    Raises
    ------
    OSError
        If it looks like a file and there is none, or `after` cannot be read.
    ValueError
        If the file is no valid TOML, or of a file that it names; or `after` is no JSON.
    """
    more: dict[str, Any] = {}
    if after is not None:
        content = read_text(after, MOST_BYTES)
        with errors_of(after):
            more = {"after": parse_json(content)}
    if text is None:
        return more
    path = Path(text)
    if path.suffix != ".toml" and len(path.parts) == 1:
        return {"preset": text, **more}
    path = Path(folder) / path
    if not path.is_file():
        raise FileNotFoundError(f"there is no scenario file {path}")
    text = read_text(path)
    with errors_of(path):
        return read_files(problem, parse_toml(text) | more, path.parent, named=named)
