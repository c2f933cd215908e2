"""Runs that are ready to be solved: new ones, from names and scenarios, and those of a folder."""

from __future__ import annotations

import copy
import json
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from pymoo.core.algorithm import Algorithm
from pymoo.core.problem import Problem

from mgeo.algorithms.starting import SuggestedSampling
from mgeo.algorithms.state import end_at
from mgeo.benchmarks.collections import is_benchmark
from mgeo.plugins import protocol
from mgeo.plugins.problems import load_problem, read_files
from mgeo.runs.algorithms import (
    build_algorithm,
    complete_parameters,
    default_algorithm,
    default_evaluations,
    keeps_checkpoints,
)
from mgeo.runs.operators import with_suggested
from mgeo.runs.solve import State, follow, set_up
from mgeo.store.checkpoint import read_notes, resume
from mgeo.store.reading import parse_json, parse_toml, read_text
from mgeo.store.run import Notes, Outcome, RunConfiguration
from mgeo.store.run_folder import CHECKPOINT_FILE, RUN_FILE, read_run
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


def resume_run(
    folder: Path | str,
    *,
    evaluations: int | None = None,
    generations: int | None = None,
    algorithm: str | None = None,
    problem: str | None = None,
    check: bool = True,
) -> PreparedRun:
    """The run of a folder, as its last checkpoint has it.

    Parameters
    ----------
    folder
        Of a run that was saved by a `RunPersistence`, finished or not.
    evaluations, generations
        A new budget, counted from the beginning of the run; at most one of them.
    algorithm, problem
        The run's, if that is ``module:Class``: a file alone has no module imported.
    check
        Whether a few points are evaluated again and compared (see `mgeo.resume`).

    Raises
    ------
    FileNotFoundError
        If the folder holds nothing to go on from.
    ValueError, TypeError
        If the checkpoint is damaged, the problem gives other values than it did, or the new
        budget is below what was made already.
    """
    folder = Path(folder)
    path = folder / CHECKPOINT_FILE
    if not path.is_file():
        raise FileNotFoundError(f"{folder} cannot be resumed: {_reason(folder)}")
    found = read_notes(path)
    with errors_of(path):
        notes = checked(Notes, found)
        configuration = notes.configuration
        _check_named("algorithm", configuration.algorithm, algorithm)
        _check_named("problem", configuration.problem, problem)
        named = () if problem is None else (problem,)
        made = load_problem(configuration.problem, configuration.options, named=named)
        same = build_algorithm(configuration.algorithm, configuration.parameters, made)
        if notes.seen and [len(side) for side in notes.seen] != [made.n_obj] * 2:
            raise ValueError(f"seen = {notes.seen!r:.80}: expected 2 x {made.n_obj} numbers")
        width = made.n_var + made.n_obj + made.n_ieq_constr + made.n_eq_constr
        if any(len(row) != width for row in notes.nearest):
            raise ValueError(f"nearest = {notes.nearest!r:.80}: expected rows of {width} numbers")
    budget = configuration.evaluations
    run = resume(path, made, ("n_eval", budget), algorithm=same, check=check)
    run.evaluator.warn = False  # the outcome tells
    if configuration.starts:  # walkers are at them already; what is left is to evaluate them
        run.sampling = SuggestedSampling(configuration.starts)
    evaluated = run.evaluator.n_eval
    if evaluations is not None and generations is not None:
        raise ValueError("evaluations and generations are both given: expected one of them")
    if evaluations is not None:
        budget = evaluations
    elif generations is not None:
        twin = copy.deepcopy(run)
        twin.n_iter = twin.n_iter or 1
        # not of a new judgment of the archive; suggested designs are evaluated in addition
        budget = generations * len(twin.candidates()) + configuration.starts
    if budget != configuration.evaluations:
        if budget < evaluated:
            raise ValueError(
                f"the new budget is {budget} evaluations: expected at least the {evaluated} that "
                "were made already"
            )
        end_at(run, ("n_eval", budget))
    return PreparedRun(configuration.model_copy(update={"evaluations": budget}), made, run, notes)


def _check_named(key: str, name: str, named: str | None) -> None:
    """Refuse to import a class that is not installed, unless the caller names it, too."""
    if named not in (None, name):
        raise ValueError(f"{key} = {name!r}: expected {named!r}, as asked for")
    if ":" in name and not is_benchmark(name) and named is None:
        raise ValueError(
            f"{key} = {name!r}: its module is imported only if it is named: --{key} {name}"
        )


def _reason(folder: Path) -> str:
    if not (folder / RUN_FILE).is_file():
        return f"there is no {CHECKPOINT_FILE} in it"
    algorithm = read_run(folder).configuration.algorithm
    if keeps_checkpoints(algorithm):
        return (
            f"there is no {CHECKPOINT_FILE} in it; {algorithm} keeps one where it is run by mgeo "
            "solve, and that was removed or left behind"
        )
    return f"{algorithm} keeps no checkpoints; only algorithms of the MGEO family do"


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
