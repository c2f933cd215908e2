"""Go on with a run from what its folder holds."""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mgeo.algorithms.state import end_at
from mgeo.files.reading import entry, errors_of
from mgeo.persistence.checkpoint import read_notes, resume
from mgeo.plugins.discovery import load_problem
from mgeo.runs.folder import RUN_FILE, read_run
from mgeo.runs.keep import CHECKPOINT_FILE, Keeper
from mgeo.runs.recipe import Recipe
from mgeo.runs.solve import Outcome, State, check_notes, follow

if TYPE_CHECKING:
    from pymoo.core.problem import Problem

    from mgeo.algorithms.base import ExtremalOptimization


@dataclass(frozen=True, eq=False)
class ResumedRun:
    """A run that has begun; can be solved once."""

    recipe: Recipe
    problem: Problem
    algorithm: ExtremalOptimization
    notes: Mapping[str, Any]

    def solve(
        self, callback: Callable[[State], object] | None = None, keeper: Keeper | None = None
    ) -> Outcome:
        """Go on to the end of the budget (see `mgeo.runs.solve.solve`)."""
        budget = self.recipe.evaluations
        return follow(self.problem, self.algorithm, budget, callback, keeper, self.notes)


def resume_run(
    folder: Path | str,
    *,
    evaluations: int | None = None,
    generations: int | None = None,
    check: bool = True,
) -> ResumedRun:
    """The run of a folder, as its last checkpoint has it.

    Parameters
    ----------
    folder
        Of a run that was kept by a `Keeper`, finished or not.
    evaluations, generations
        A new budget, counted from the beginning of the run; at most one of them.
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
    notes = read_notes(path)
    with errors_of(path):
        recipe = Recipe.from_dict(entry(notes, "recipe", dict))
        entry(notes, "record", bool)
        problem = load_problem(recipe.problem, recipe.options)
        check_notes(notes, problem)
    algorithm = resume(path, problem, ("n_eval", recipe.evaluations), check=check)
    algorithm.evaluator.warn = False  # the outcome tells
    budget, made = recipe.evaluations, algorithm.evaluator.n_eval
    if evaluations is not None and generations is not None:
        raise ValueError("evaluations and generations are both given: expected one of them")
    if evaluations is not None:
        budget = evaluations
    elif generations is not None:
        budget = generations * len(copy.deepcopy(algorithm).ask())
    if budget != recipe.evaluations:
        if budget < made:
            raise ValueError(
                f"the new budget is {budget} evaluations: expected at least the {made} that were "
                "made already"
            )
        end_at(algorithm, ("n_eval", budget))
    return ResumedRun(replace(recipe, evaluations=budget), problem, algorithm, notes)


def _reason(folder: Path) -> str:
    if not (folder / RUN_FILE).is_file():
        return f"there is no {CHECKPOINT_FILE} in it"
    algorithm = read_run(folder).recipe.algorithm
    return f"{algorithm} keeps no checkpoints; only algorithms of the MGEO family do"
