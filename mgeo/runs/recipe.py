"""Everything that determines a run, as plain data."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from mgeo._validation import integer
from mgeo.files.reading import entry
from mgeo.plugins import protocol
from mgeo.plugins.discovery import load_problem
from mgeo.plugins.protocol import column_names
from mgeo.runs.algorithms import (
    DEFAULT,
    build_algorithm,
    complete_parameters,
    default_evaluations,
)
from mgeo.runs.solve import Outcome, State, set_up, solve

if TYPE_CHECKING:
    from pymoo.core.algorithm import Algorithm
    from pymoo.core.problem import Problem

    from mgeo.runs.keep import Keeper

_KINDS: Mapping[str, type] = {
    "problem": str,
    "options": dict,
    "algorithm": str,
    "parameters": dict,
    "evaluations": int,
    "seed": int,
}


@dataclass(frozen=True)
class Recipe:
    """A run to be made, or made again: the same recipe gives the same front.

    ``problem`` and ``algorithm`` are names (see `mgeo.plugins.discovery` and
    `mgeo.runs.algorithms`), ``options`` and ``parameters`` what they are built from,
    ``evaluations`` the budget.
    """

    problem: str
    options: Mapping[str, Any]
    algorithm: str
    parameters: Mapping[str, Any]
    evaluations: int
    seed: int

    def prepare(self) -> PreparedRun:
        """Build the problem and the algorithm.

        Raises
        ------
        ValueError, TypeError
            If a name, an option or a parameter is refused.
        """
        problem = load_problem(self.problem, self.options)
        algorithm = build_algorithm(self.algorithm, self.parameters, problem)
        return _checked(PreparedRun(self, problem, algorithm))

    def to_dict(self) -> dict[str, Any]:
        """As `from_dict` takes it."""
        return asdict(self)

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Recipe:
        """From a mapping whose keys are the attributes.

        Raises
        ------
        ValueError, TypeError
            Naming the key that is missing, unknown or of the wrong type.
        """
        for key, kind in _KINDS.items():
            entry(data, key, kind)
        unknown = set(data) - set(_KINDS)
        if unknown:
            raise ValueError(f"{min(unknown)} is unknown: expected {', '.join(_KINDS)}")
        integer("evaluations", data["evaluations"], low=1)
        integer("seed", data["seed"], low=0)
        return cls(**data)


@dataclass(frozen=True, eq=False)
class PreparedRun:
    """A recipe and what was built from it; can be solved more than once."""

    recipe: Recipe
    problem: Problem
    algorithm: Algorithm

    def solve(
        self, callback: Callable[[State], object] | None = None, keeper: Keeper | None = None
    ) -> Outcome:
        """Run it (see `mgeo.runs.solve.solve`)."""
        recipe = self.recipe
        return solve(
            self.problem, self.algorithm, recipe.evaluations, recipe.seed, callback, keeper
        )


def prepare(
    problem: str,
    options: Mapping[str, Any] | None = None,
    *,
    algorithm: str = DEFAULT,
    parameters: Mapping[str, Any] | None = None,
    evaluations: int | None = None,
    seed: int = 1,
) -> PreparedRun:
    """A run whose recipe leaves nothing to defaults that may change.

    The problem's own ``options()`` are written out, the algorithm's parameters completed, and the
    budget is `default_evaluations` if none is given.

    Raises
    ------
    ValueError, TypeError
        If a name, an option or a parameter is refused, or the options are no JSON values.
    """
    complete = complete_parameters(algorithm, parameters or {})
    built = load_problem(problem, options)
    optimizer = build_algorithm(algorithm, complete, built)
    own = protocol.options(built)
    effective = dict(options or {}) if own is None else own
    if evaluations is None:
        evaluations = default_evaluations(optimizer, built)
    recipe = Recipe(problem, effective, algorithm, complete, evaluations, seed)
    return _checked(PreparedRun(_as_read_back(recipe), built, optimizer))


def _checked(run: PreparedRun) -> PreparedRun:
    # what is refused only once problem and algorithm are known is refused here, not in `solve`
    column_names(run.problem)
    set_up(run.problem, run.algorithm, run.recipe.evaluations, run.recipe.seed)
    return run


def _as_read_back(recipe: Recipe) -> Recipe:
    """The recipe as a file gives it, so that a run made now and one made again are the same."""
    try:
        text = json.dumps(recipe.to_dict(), allow_nan=False)
    except (TypeError, ValueError) as error:
        raise ValueError(
            f"the options of {recipe.problem!r} are no JSON values: {error}"
        ) from error
    return Recipe.from_dict(json.loads(text))
