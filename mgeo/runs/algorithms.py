"""Algorithms by name: the MGEO family, those of pymoo and of others, imported when one is built."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from importlib import import_module
from typing import TYPE_CHECKING, Any

from mgeo.algorithms import constructors
from mgeo.algorithms.base import EXECUTIONS, ExtremalOptimization
from mgeo.plugins import discovery
from mgeo.plugins.discovery import load_algorithm
from mgeo.validation.arguments import did_you_mean, validate_integer

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray
    from pymoo.core.algorithm import Algorithm
    from pymoo.core.problem import Problem

DEFAULT, ROBUST = "mgeo-directed", "mgeo-staged"
_MOST_POPULATION = 100_000
_NOT_SET = ("sampling", "archive_size")  # parameters that a run in a folder leaves as they are

# Module and class, and what the population stands for in the constructors of others; without
# that, the parameters are those of the class.
_PYMOO = "pymoo.algorithms"
ALGORITHMS: Mapping[str, tuple[str, ...]] = {
    "mgeo-real": ("mgeo.algorithms", "MGEOReal"),
    "mgeo-real2": ("mgeo.algorithms", "MGEOReal2"),
    "mgeo-canonical": ("mgeo.algorithms", "MGEOCanonical"),
    "mgeo-var": ("mgeo.algorithms", "MGEOVar"),
    DEFAULT: ("mgeo.algorithms", "MGEODirected"),
    ROBUST: ("mgeo.algorithms", "MGEOStaged"),
    "nsga2": (f"{_PYMOO}.moo.nsga2", "NSGA2", "pop_size"),
    "nsga3": (f"{_PYMOO}.moo.nsga3", "NSGA3", "ref_dirs", "pop_size"),
    "u-nsga3": (f"{_PYMOO}.moo.unsga3", "UNSGA3", "ref_dirs", "pop_size"),
    "spea2": (f"{_PYMOO}.moo.spea2", "SPEA2", "pop_size"),
    "sms-emoa": (f"{_PYMOO}.moo.sms", "SMSEMOA", "pop_size"),
    "age-moea2": (f"{_PYMOO}.moo.age2", "AGEMOEA2", "pop_size"),
    "moead": (f"{_PYMOO}.moo.moead", "MOEAD", "ref_dirs"),
    "ctaea": (f"{_PYMOO}.moo.ctaea", "CTAEA", "ref_dirs"),
    "gde3": (f"{_PYMOO}.moo.gde3", "GDE3", "pop_size"),
    "nsde": (f"{_PYMOO}.moo.nsde", "NSDE", "pop_size"),
    "mopso-cd": (f"{_PYMOO}.moo.mopso_cd", "MOPSO_CD", "pop_size"),
    "cmopso": (f"{_PYMOO}.moo.cmopso", "CMOPSO", "pop_size"),
    "rvea": ("mgeo.runs.pymoo_algorithms", "FrontRVEA", "ref_dirs"),
    "random": (f"{_PYMOO}.soo.nonconvex.random_search", "RandomSearch", "n_points_per_iteration"),
}
FAMILY = [name for name, (_, _, *population) in ALGORITHMS.items() if not population]


def default_algorithm(robust: bool) -> str:
    """The algorithm of a run for which none is named."""
    return ROBUST if robust else DEFAULT


def algorithm_names() -> list[str]:
    """All names, those of installed plugins after mgeo's own, which none replaces."""
    others = (plugin.name for plugin in discovery.installed_plugins(discovery.ALGORITHMS))
    return list(dict.fromkeys([*ALGORITHMS, *others]))


def build_algorithm(name: str, parameters: Mapping[str, Any], problem: Problem) -> Algorithm:
    """The algorithm of this name, ready to be set up on `problem`.

    Raises
    ------
    ValueError
        If the name or a parameter is unknown, a value is refused, or the algorithm cannot treat
        the problem.
    """
    complete = complete_parameters(name, parameters)
    try:
        cls = _class(name)
    except (ImportError, AttributeError) as error:
        raise ValueError(f"algorithm {name!r} is not in the installed pymoo: {error}") from error
    if name not in ALGORITHMS:
        own = Exception if issubclass(cls, ExtremalOptimization) else ValueError  # on a parameter
        with discovery.code_of_others(f"algorithm {name!r} cannot be built:", own):
            made: Algorithm = cls(**complete)
        return made
    if name in FAMILY:
        return cls(**complete)
    population = validate_integer(
        "population", complete["population"], low=4, high=_MOST_POPULATION
    )
    if name == "moead" and problem.has_constraints():
        raise ValueError("algorithm 'moead' does not treat constraints, which this problem has")
    declared = getattr(problem, "vars", None) is not None  # with bounds of their own
    if not declared and name != "random" and (problem.xl is None or problem.xu is None):
        raise ValueError(f"algorithm {name!r} needs bounds, which this problem does not have")
    given: dict[str, Any] = dict.fromkeys(ALGORITHMS[name][2:], population)
    if "ref_dirs" in given:
        given["ref_dirs"] = _directions(population, problem)
    from mgeo.runs.operators import fitted  # imports algorithms

    return fitted(cls(**given), problem, f"algorithm {name!r}")


def complete_parameters(name: str, parameters: Mapping[str, Any]) -> dict[str, Any]:
    """All parameters of an algorithm: those given and the defaults of the others.

    Raises
    ------
    ValueError
        If the name or a parameter is unknown.
    TypeError
        If `parameters` is no mapping.
    """
    if ":" not in name and name not in (names := algorithm_names()):
        raise ValueError(
            f"no algorithm is called {name!r}: expected one of {', '.join(names)}, or module:Class"
            f"{did_you_mean(name, names)}"
        )
    if not isinstance(parameters, Mapping):
        raise TypeError(f"parameters = {parameters!r}: expected a mapping of names to values")
    known = _parameters(name)
    if "n_walkers" in known:
        parameters = constructors.with_n_walkers(parameters)
    if not _is_pymoos(name):
        parameters = constructors.without_constants(_class(name), parameters)
    for key in parameters:
        if key not in known:
            expected = ", ".join(known) or "none"
            raise ValueError(
                f"algorithm {name!r} has no parameter {key!r}: expected {expected}"
                f"{constructors.of_papers(key)}"
            )
    return {key: value for key, value in known.items() if _is_plain(value)} | dict(parameters)


def default_evaluations(algorithm: Algorithm, problem: Problem) -> int:
    """What `mgeo.MGEOReal` makes by default; the same for every algorithm, so that runs compare.

    That is the paper's 5000 generations of one candidate per variable, shared by the walkers:
    59,760 for 12 variables and 30 walkers, which are also assumed where there are no walkers.
    """
    walkers = getattr(algorithm, "n_walkers", 30)
    return int(max(1, EXECUTIONS // walkers) * walkers * problem.n_var)


def described(name: str) -> dict[str, Any]:
    """``name``, ``about``, what it is in a line, ``parameters``: name, default, meaning of each.

    It raises as `complete_parameters`.
    """
    defaults = complete_parameters(name, {})
    cls = _class(name)
    if _is_pymoos(name):
        about, meanings = f"{cls.__module__}.{cls.__qualname__}", {"population": "its size"}
    else:
        about = (inspect.getdoc(cls) or "").partition("\n")[0]
        meanings = constructors.descriptions(cls)
    rows = [
        {"name": key, "default": value, "meaning": meanings.get(key, "")}
        for key, value in defaults.items()
    ]
    return {"name": name, "about": about, "parameters": rows}


def with_parameter(parameter: str) -> list[str]:
    """Members of the family that have a parameter of this name."""
    return [name for name in FAMILY if parameter in _parameters(name)]


def keeps_checkpoints(name: str) -> bool:
    """Whether runs of an algorithm can be resumed.

    Of ``module:Class``, which is not imported because a file names it, that is taken for granted.
    """
    return ":" in name or issubclass(_class(name), ExtremalOptimization)


def _is_pymoos(name: str) -> bool:
    """Whether only its population can be set: it is neither of the family nor of a plugin."""
    return name in ALGORITHMS and name not in FAMILY


def _class(name: str) -> Any:
    if name not in ALGORITHMS:
        return load_algorithm(name)
    module, cls, *_ = ALGORITHMS[name]
    return getattr(import_module(module), cls)


def _parameters(name: str) -> dict[str, Any]:
    """All parameters of an algorithm and their defaults, `inspect.Parameter.empty` for none."""
    if _is_pymoos(name):
        return {"population": 100}
    cls, left_out = _class(name), {*_NOT_SET}
    root: type = ExtremalOptimization
    if not issubclass(cls, root):  # only what its own constructor names: others may pass it on
        from pymoo.core.algorithm import Algorithm

        root = next(each for each in cls.__mro__ if "__init__" in vars(each))
        left_out |= constructors.named(Algorithm)
    known = constructors.parameters(cls, root)
    return {key: p.default for key, p in known.items() if key not in left_out}


def _is_plain(value: Any) -> bool:
    """Whether a default can be written into a file; operators and the like cannot."""
    if isinstance(value, list | tuple):
        return all(map(_is_plain, value))
    return value is None or isinstance(value, bool | int | float | str)


def _directions(population: int, problem: Problem) -> NDArray[np.float64]:
    """As many evenly spaced directions (Das and Dennis) as fit into the population."""
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
