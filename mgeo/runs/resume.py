"""Continue a run from the checkpoint in its folder."""

from __future__ import annotations

import copy
from pathlib import Path

from mgeo.algorithms.starting import SuggestedSampling
from mgeo.algorithms.state import end_at
from mgeo.benchmarks.collections import is_benchmark
from mgeo.plugins.problems import load_problem
from mgeo.runs.algorithms import build_algorithm
from mgeo.runs.prepare import PreparedRun
from mgeo.store.checkpoint import read_notes, resume
from mgeo.store.run import Notes
from mgeo.store.run_folder import CHECKPOINT_FILE
from mgeo.validation.entries import errors_of
from mgeo.validation.tables import checked


def resume_run(
    folder: Path | str,
    *,
    evaluations: int | None = None,
    generations: int | None = None,
    algorithm: str | None = None,
    problem: str | None = None,
    check: bool = True,
) -> PreparedRun:
    """Return the run of a folder in the state of its last checkpoint.

    Parameters
    ----------
    folder
        Folder of a run that was saved by `RunPersistence`, finished or not.
    evaluations, generations
        New budget, counted from the beginning of the run; at most one of them.
    algorithm, problem
        Class of the run, ``module:Class``. No module is imported because a file names it.
    check
        Whether versions and a few values of the problem must be those of the run (see
        `mgeo.resume`).

    Raises
    ------
    FileNotFoundError
        If the folder has no checkpoint.
    ValueError, TypeError
        If the checkpoint is damaged; if problem, parameters or versions are not those of the run,
        naming the difference; or if the new budget is less than what was evaluated already.
    """
    path = Path(folder) / CHECKPOINT_FILE
    if not path.is_file():
        raise FileNotFoundError(
            f"{folder} cannot be resumed: there is no {CHECKPOINT_FILE} in it; only algorithms of "
            "the MGEO family write one"
        )
    if evaluations is not None and generations is not None:
        raise ValueError("evaluations and generations are both given: expected one of them")
    found = read_notes(path)
    with errors_of(path):
        notes = checked(Notes, found)
        configuration = notes.configuration
        _check_named("algorithm", configuration.algorithm, algorithm)
        _check_named("problem", configuration.problem, problem)
        named = () if problem is None else (problem,)
        loaded = load_problem(configuration.problem, configuration.options, named=named)
        same = build_algorithm(configuration.algorithm, configuration.parameters, loaded)
    budget = configuration.evaluations
    run = resume(path, loaded, ("n_eval", budget), algorithm=same, check=check)
    run.evaluator.warn = False  # the outcome has the failures
    if configuration.starts:
        run.sampling = SuggestedSampling(configuration.starts)
    if evaluations is not None:
        budget = evaluations
    elif generations is not None:
        twin = copy.deepcopy(run)
        twin.n_iter = twin.n_iter or 1
        # `candidates` leaves out the re-evaluation of the archive; suggested designs are extra
        budget = generations * len(twin.candidates()) + configuration.starts
    if budget != configuration.evaluations:
        evaluated = run.evaluator.n_eval
        if budget < evaluated:
            raise ValueError(
                f"the new budget is {budget} evaluations: expected at least the {evaluated} that "
                "were made already"
            )
        end_at(run, ("n_eval", budget))
    longer = configuration.model_copy(update={"evaluations": budget})
    return PreparedRun(longer, loaded, run, notes)


def _check_named(key: str, name: str, named: str | None) -> None:
    """Refuse to import a class that is not installed, unless the caller names it, too."""
    if named not in (None, name):
        raise ValueError(f"{key} = {name!r}: expected {named!r}, as asked for")
    if ":" in name and not is_benchmark(name) and named is None:
        raise ValueError(
            f"{key} = {name!r}: its module is imported only if it is named: --{key} {name}"
        )
