"""Construction of algorithms by name, their parameters, and their preparation for a run."""

from __future__ import annotations

import copy
import inspect
from collections.abc import Mapping
from pkgutil import resolve_name
from typing import TYPE_CHECKING, Any

from pymoo.core.sampling import Sampling

from mgeo.algorithms.base import DEFAULT_WALKER_GENERATIONS, ExtremalOptimization
from mgeo.algorithms.initial_designs import SuggestedSampling
from mgeo.algorithms.variables import KINDS, Variables, get_kind
from mgeo.evaluation.evaluator import TolerantEvaluator
from mgeo.plugins import discovery
from mgeo.plugins.discovery import load_algorithm
from mgeo.runs.registry import ALGORITHMS, DEFAULT_ALGORITHM, ROBUST_ALGORITHM
from mgeo.validation import constructors
from mgeo.validation.arguments import format_suggestion, validate_integer

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray
    from pymoo.core.algorithm import Algorithm
    from pymoo.core.problem import Problem

    from mgeo.documents import AlgorithmDocument, Parameter

#: Number of generations without an evaluation after which a run ends.
MAX_IDLE_GENERATIONS = 100

_MAX_POPULATION = 100_000
_HIDDEN_PARAMETERS = ("sampling", "archive_size")  # Users cannot set these parameters.


def select_default_algorithm(robust: bool) -> str:
    """Return the default algorithm of ``mgeo solve``, with or without ``--robust``."""
    return ROBUST_ALGORITHM if robust else DEFAULT_ALGORITHM


def list_algorithms() -> list[str]:
    """Return the names of all algorithms: built-in algorithms, then installed plugins."""
    plugins = (plugin.name for plugin in discovery.list_plugins(discovery.ALGORITHMS))
    return list(dict.fromkeys([*ALGORITHMS, *plugins]))


def build_algorithm(name: str, parameters: Mapping[str, Any], problem: Problem) -> Algorithm:
    """Build an algorithm for a problem from its name and parameters.

    Parameters
    ----------
    name : str
        Name of an algorithm, or ``module:Class``.
    parameters : mapping
        Parameters that differ from the defaults.
    problem : Problem
        Problem to solve, which determines the operators of pymoo's algorithms.

    Returns
    -------
    Algorithm
        Algorithm that is not set up.

    Raises
    ------
    ValueError
        If the name or a parameter is unknown, a value is invalid, or the algorithm does not support
        the constraints or variables of the problem.
    """
    all_parameters = complete_parameters(name, parameters)
    cls = _load_class(name)
    if not _has_population_only(name):
        passed_on = ValueError, TypeError  # Errors of parameters keep their type.
        with discovery.convert_plugin_errors(f"algorithm {name!r} cannot be built:", *passed_on):
            algorithm: Algorithm = cls(**all_parameters)
        return algorithm
    population = validate_integer(
        "population", all_parameters["population"], low=4, high=_MAX_POPULATION
    )
    record = ALGORITHMS[name]
    if not record.supports_constraints and problem.has_constraints():
        raise ValueError(f"algorithm {name!r} does not support the constraints of this problem")
    # Variables that are declared one by one have their own bounds.
    is_declared = getattr(problem, "vars", None) is not None
    if not is_declared and name != "random" and (problem.xl is None or problem.xu is None):
        raise ValueError(f"algorithm {name!r} needs bounds, which this problem does not have")
    arguments: dict[str, Any] = dict.fromkeys(record.population_arguments, population)
    if "ref_dirs" in arguments:
        arguments["ref_dirs"] = _build_reference_directions(population, problem)
    algorithm = cls(**arguments)
    kind = "mixed" if is_declared else get_kind(problem.vtype)
    if kind not in (None, "real"):
        from mgeo.runs.pymoo_algorithms import replace_operators  # The import is slow.

        Variables.from_problem(problem, KINDS)  # Raises an error if a bound is missing or invalid.
        replace_operators(kind, algorithm, name)
    return algorithm


def set_up(
    problem: Problem, algorithm: Algorithm, evaluations: int, seed: int, initial_designs: int = 0
) -> Algorithm:
    """Return a copy of an algorithm that is set up for a problem and ready to run.

    The evaluator of the copy tolerates failed evaluations (see `mgeo.TolerantEvaluator`).

    Parameters
    ----------
    problem : Problem
        Problem to solve.
    algorithm : Algorithm
        Algorithm that is not set up.
    evaluations : int
        Budget of evaluations.
    seed : int
        Seed of all random numbers.
    initial_designs : int
        Number of initial designs that the problem suggests.

    Returns
    -------
    Algorithm

    Raises
    ------
    ValueError
        If the algorithm does not support the problem or the number of initial designs.
    """
    prepared = copy.deepcopy(algorithm)
    if initial_designs:
        use_suggested_designs(prepared, initial_designs)
    prepared.evaluator = TolerantEvaluator.from_evaluator(prepared.evaluator)
    prepared.evaluator.warn = False  # The outcome reports the failures.
    prepared.setup(problem, termination=("n_eval", evaluations), seed=seed)
    if not isinstance(prepared, ExtremalOptimization):
        from mgeo.runs.pymoo_algorithms import use_seeded_generator  # The import is slow.

        use_seeded_generator(prepared)
    return prepared


def use_suggested_designs(algorithm: Algorithm, n_suggested: int) -> None:
    """Make an algorithm start from initial designs suggested by its problem.

    The remaining initial designs come from the algorithm's own sampling.

    Raises
    ------
    ValueError
        If the algorithm accepts no initial designs, or fewer than `n_suggested`.
    """
    name = type(algorithm).__name__
    n_max = getattr(algorithm, "n_walkers", None) or getattr(algorithm, "pop_size", None)
    if n_max is not None and n_suggested > n_max:
        raise ValueError(
            f"initial_designs = {n_suggested}: expected at most {n_max}, the number of walkers or "
            f"population size of {name}"
        )
    if isinstance(algorithm, ExtremalOptimization):
        algorithm.sampling = SuggestedSampling(n_suggested)
        return
    initialization: Any = getattr(algorithm, "initialization", None)
    if not isinstance(getattr(initialization, "sampling", None), Sampling):
        raise ValueError(
            f"initial_designs = {n_suggested}: {name} accepts no initial designs: expected 0"
        )
    initialization.sampling = SuggestedSampling(n_suggested, initialization.sampling)


def complete_parameters(name: str, parameters: Mapping[str, Any]) -> dict[str, Any]:
    """Return all parameters of an algorithm, with defaults for those not given.

    Raises
    ------
    ValueError
        If the name or a parameter is unknown.
    TypeError
        If `parameters` is not a mapping.
    """
    # The metadata of all packages are read only for a name that is not built in.
    is_built_in = ":" in name or name in ALGORITHMS
    if not is_built_in and name not in (names := list_algorithms()):
        raise ValueError(
            f"there is no algorithm {name!r}: expected a name from `mgeo algorithms`, or "
            f"module:Class{format_suggestion(name, names)}"
        )
    if not isinstance(parameters, Mapping):
        raise TypeError(f"parameters = {parameters!r}: expected a mapping of names to values")
    defaults = _list_default_parameters(name)
    for key in parameters:
        if key not in defaults:
            expected = ", ".join(defaults) or "none"
            raise ValueError(
                f"algorithm {name!r} has no parameter {key!r}: expected {expected}"
                f"{format_suggestion(key, defaults)}"
            )
    basic_defaults = {key: value for key, value in defaults.items() if _is_basic_value(value)}
    return basic_defaults | dict(parameters)


def compute_default_budget(algorithm: Algorithm, problem: Problem) -> int:
    """Return the default number of evaluations of a run.

    The budget is 5000 generations with one candidate per variable, as in the publications, rounded
    down to equal shares of the walkers: 59,760 evaluations for 12 variables and 30 walkers.
    Algorithms without walkers have the budget of 30 walkers.
    """
    walkers = getattr(algorithm, "n_walkers", 30)
    return int(max(1, DEFAULT_WALKER_GENERATIONS // walkers) * walkers * problem.n_var)


def describe_algorithm(name: str) -> AlgorithmDocument:
    """Return the name, description and parameters of an algorithm as a JSON-serializable dict.

    ``mgeo algorithms`` prints this dict.

    Returns
    -------
    AlgorithmDocument
        Dict with the keys that the JSON document declares.

    Raises
    ------
    ValueError
        If the name is unknown.
    """
    defaults = complete_parameters(name, {})
    if _has_population_only(name):
        meanings = {"population": "size of the population"}
    else:
        meanings = constructors.get_parameter_descriptions(_load_class(name))
    if name in ALGORITHMS:
        label, description = ALGORITHMS[name].label, ALGORITHMS[name].description
    else:
        label, description = name, (inspect.getdoc(_load_class(name)) or "").partition("\n")[0]
    library = "pymoo" if _has_population_only(name) else _load_class(name).__module__.split(".")[0]
    rows: list[Parameter] = [
        {"name": key, "default": value, "meaning": meanings.get(key, "")}
        for key, value in defaults.items()
    ]
    return {
        "name": name,
        "label": label,
        "library": library,
        "description": description,
        "parameters": rows,
    }


def _has_population_only(name: str) -> bool:
    return name in ALGORITHMS and bool(ALGORITHMS[name].population_arguments)


def _load_class(name: str) -> Any:
    if name in ALGORITHMS:
        return resolve_name(ALGORITHMS[name].path)
    return load_algorithm(name)


def _list_default_parameters(name: str) -> dict[str, Any]:
    if _has_population_only(name):
        return {"population": 100}
    cls, omitted = _load_class(name), {*_HIDDEN_PARAMETERS}
    root: type = ExtremalOptimization
    if not issubclass(cls, root):  # Only the constructor of the class itself defines parameters.
        from pymoo.core.algorithm import Algorithm

        root = next(base for base in cls.__mro__ if "__init__" in vars(base))
        omitted |= constructors.get_parameters(Algorithm, Algorithm).keys()
    parameters = constructors.get_parameters(cls, root)
    return {key: p.default for key, p in parameters.items() if key not in omitted}


def _is_basic_value(value: Any) -> bool:
    """Return whether a value is None, a boolean, a number, a string, or a nested list of these."""
    if isinstance(value, list | tuple):
        return all(map(_is_basic_value, value))
    return value is None or isinstance(value, bool | int | float | str)


def _build_reference_directions(population: int, problem: Problem) -> NDArray[np.float64]:
    """Return the largest set of Das-Dennis directions that does not exceed `population`.

    Returns
    -------
    array, shape (n, n_obj)
    """
    if problem.n_obj < 2:
        raise ValueError("an algorithm with reference directions needs 2 or more objectives")
    from pymoo.util.ref_dirs import get_reference_directions
    from pymoo.util.reference_direction import get_partition_closest_to_points

    partitions = get_partition_closest_to_points(population, problem.n_obj)
    if partitions < 1:
        raise ValueError(
            f"population = {population}: expected >= {problem.n_obj}, one per objective"
        )
    directions: NDArray[np.float64] = get_reference_directions(
        "das-dennis", problem.n_obj, n_partitions=partitions
    )
    return directions
