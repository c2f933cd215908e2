"""Go on with a run from what its folder holds."""

from __future__ import annotations

import copy
from pathlib import Path

from mgeo.algorithms.starting import SuggestedSampling
from mgeo.algorithms.state import end_at
from mgeo.benchmarks.collections import is_benchmark
from mgeo.plugins.problems import load_problem
from mgeo.runs.algorithms import build_algorithm, keeps_checkpoints
from mgeo.runs.prepare import PreparedRun
from mgeo.store.checkpoint import read_notes, resume
from mgeo.store.run import Notes
from mgeo.store.run_folder import CHECKPOINT_FILE, RUN_FILE, read_run
from mgeo.validation.tables import checked, errors_of


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
