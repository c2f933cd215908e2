"""Fast construction and reading of pymoo populations, and conversion of designs to numbers."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pymoo.core.individual import Individual
from pymoo.core.population import Population
from pymoo.core.problem import Problem
from pymoo.core.variable import Choice

from mgeo._typing import BoolArray, FloatArray


def build_population(X: NDArray[Any]) -> Population:
    """Create a population of unevaluated individuals from an array of designs.

    This function is faster than ``Population.new("X", X)``, which spends most of its time on a
    separate configuration of each individual. Here, all individuals share one configuration.

    Parameters
    ----------
    X : array, shape (n, n_var), or (n,) for designs that are objects
        Design vectors. Each individual holds a copy of its row, so that an archived individual does
        not keep the whole batch in memory.

    Returns
    -------
    Population
        n individuals.
    """
    template = vars(Individual())
    population = np.empty(len(X), dtype=object)
    for i, design in enumerate(X):
        individual = population[i] = Individual.__new__(Individual)
        individual.__dict__ = {**template, "_X": copy_array(design), "data": {}, "evaluated": set()}
    return population.view(Population)


def copy_array(value: Any) -> Any:
    """Copy an array, or return any other object unchanged.

    A copy of a row does not keep the whole array in memory.
    """
    return value.copy() if isinstance(value, np.ndarray) else value


def get_values(population: Population, name: str) -> NDArray[Any]:
    """Return one attribute of all individuals, such as "X" or "F", as an array.

    This function is a faster equivalent of ``population.get(name)``.
    """
    return np.array([getattr(individual, name) for individual in population.tolist()])


def find_successful(population: Population) -> BoolArray:
    """Return a boolean mask of the individuals whose evaluation has not failed."""
    return np.array([not mark for mark in population.get("failed")], dtype=np.bool_)


def get_variable_names(problem: Problem) -> tuple[str, ...] | None:
    """Return the names of the variables of a problem, or None if it does not declare ``vars``."""
    declared = getattr(problem, "vars", None)
    return None if declared is None else tuple(declared)


def get_choice_options(problem: Problem) -> dict[str, tuple[Any, ...]]:
    """Return a dict that maps each choice variable of a problem to its options.

    Raises
    ------
    ValueError
        If a choice has no options or the same option twice.
    """
    options_by_name: dict[str, tuple[Any, ...]] = {}
    for name, variable in (getattr(problem, "vars", None) or {}).items():
        if isinstance(variable, Choice):
            declared = variable.options
            options = () if declared is None else tuple(declared)
            if not options or any(option in options[:i] for i, option in enumerate(options)):
                raise ValueError(
                    f"{type(problem).__name__}.vars[{name!r}].options = {declared!r:.80}: expected "
                    "at least one option and no duplicates"
                )
            options_by_name[name] = options
    return options_by_name


def convert_dicts_to_numbers(
    designs: NDArray[Any], names: Sequence[str], options: Mapping[str, Sequence[Any]]
) -> FloatArray:
    """Convert mixed-variable designs from dicts to rows of numbers.

    Parameters
    ----------
    designs : array of dict, shape (n,)
        Dicts that map variable names to values.
    names : sequence of str, length n_var
        Variables in the order of the columns.
    options : mapping of str to sequence
        Options of each choice variable. A choice is encoded as the index of its option.

    Returns
    -------
    array of float, shape (n, n_var)

    Raises
    ------
    KeyError
        If a design lacks a variable.
    ValueError
        If a value is neither a number nor one of the options of its variable.
    """
    table = np.empty((len(designs), len(names)))
    for j, name in enumerate(names):
        column = [design[name] for design in designs]
        if name in options:
            column = [options[name].index(value) for value in column]
        table[:, j] = column
    return table


def convert_designs_to_numbers(problem: Problem, X: NDArray[Any]) -> NDArray[Any]:
    """Convert the designs of a problem to rows of numbers.

    A choice is encoded as the index of its option.

    Parameters
    ----------
    problem : Problem
    X : array, shape (n, n_var), or array of dict, shape (n,)
        Designs.

    Returns
    -------
    array, shape (n, n_var)

    Raises
    ------
    ValueError
        If a variable is neither a number nor one of the options of its choice.
    """
    names = get_variable_names(problem)
    try:
        if names is not None and len(X) and isinstance(X[0], dict):
            X = convert_dicts_to_numbers(X, names, get_choice_options(problem))
        X = X.astype(float) if X.dtype == object else X
    except (TypeError, ValueError) as error:
        raise ValueError(f"variables of {type(problem).__name__}: {error}") from error
    return X.reshape(-1, problem.n_var)
