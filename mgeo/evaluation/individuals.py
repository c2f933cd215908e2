"""Populations of pymoo, made and read at a fraction of the usual cost, and designs as numbers."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pymoo.core.individual import Individual
from pymoo.core.population import Population
from pymoo.core.problem import Problem
from pymoo.core.variable import Choice

from mgeo._typing import BoolArray, FloatArray


def individuals(X: NDArray[Any]) -> Population:
    """New individuals at (n, n_var) design vectors, or (n,) of them that are objects.

    They are copies of one blank individual, whose configuration they share: most of what the
    constructor spends goes into a configuration of its own for each, and the memory and garbage
    collection of that. Each has its own copy of its design, so that an archive which keeps few of
    a batch does not keep the batch.
    """
    blank = vars(Individual())
    made = np.empty(len(X), dtype=object)
    for i, design in enumerate(X):
        individual = made[i] = Individual.__new__(Individual)
        individual.__dict__ = {**blank, "_X": own(design), "data": {}, "evaluated": set()}
    return made.view(Population)


def own(value: Any) -> Any:
    """A copy of a row of an array, which would keep the whole array; anything else as it is."""
    return value.copy() if isinstance(value, np.ndarray) else value


def values_of(population: Population, name: str) -> NDArray[Any]:
    """What `Population.get` gives for an attribute of individuals, such as "X" or "F"."""
    return np.array([getattr(individual, name) for individual in population.tolist()])


def succeeded(population: Population) -> BoolArray:
    """(n,) mask of the individuals that are not marked as failed by a `mgeo.TolerantEvaluator`."""
    return np.array([not mark for mark in population.get("failed")], dtype=np.bool_)


def variable_names(problem: Problem) -> tuple[str, ...] | None:
    """Names of the variables of a problem made by ``Problem(vars={...})``, else None."""
    declared = getattr(problem, "vars", None)
    return None if declared is None else tuple(declared)


def options_of(problem: Problem) -> dict[str, tuple[Any, ...]]:
    """Options of each `Choice` among its variables, by name, in their order.

    Raises
    ------
    ValueError : if there are none, or equal ones.
    """
    found: dict[str, tuple[Any, ...]] = {}
    for name, variable in (getattr(problem, "vars", None) or {}).items():
        if isinstance(variable, Choice):
            given = variable.options
            options = () if given is None else tuple(given)
            if not options or any(option in options[:i] for i, option in enumerate(options)):
                raise ValueError(
                    f"{type(problem).__name__}.vars[{name!r}].options = {given!r:.80}: expected "
                    "at least one, each once"
                )
            found[name] = options
    return found


def numbers(
    designs: NDArray[Any], names: Sequence[str], options: Mapping[str, Sequence[Any]]
) -> FloatArray:
    """(n, n_var) design vectors that are dicts, as numbers: of a choice that of its option.

    KeyError or ValueError if a name is missing, an option not known, or a value no number.
    """
    found = np.empty((len(designs), len(names)))
    for j, name in enumerate(names):
        column = [design[name] for design in designs]
        if name in options:
            column = [options[name].index(value) for value in column]
        found[:, j] = column
    return found


def as_numbers(problem: Problem, X: NDArray[Any]) -> NDArray[Any]:
    """(n, n_var) design vectors as numbers, also where each of them is a dict.

    Raises
    ------
    ValueError : if a variable is not a number, nor one of the options of a choice.
    """
    names = variable_names(problem)
    try:
        if names is not None and len(X) and isinstance(X[0], dict):
            X = numbers(X, names, options_of(problem))
        X = X.astype(float) if X.dtype == object else X
    except (TypeError, ValueError) as error:
        raise ValueError(f"variables of {type(problem).__name__}: {error}") from error
    return X.reshape(-1, problem.n_var)
