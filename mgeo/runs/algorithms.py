"""Algorithms by name: the MGEO family and those of pymoo, imported only when one is built."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING, Any

from mgeo.algorithms.base import EXECUTIONS
from mgeo.algorithms.parameters import integer

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray
    from pymoo.core.algorithm import Algorithm
    from pymoo.core.problem import Problem

DEFAULT = "mgeo-real"
_MOST_POPULATION = 100_000


def build_algorithm(name: str, parameters: Mapping[str, Any], problem: Problem) -> Algorithm:
    """The algorithm of this name, ready to be set up on `problem`.

    Raises
    ------
    ValueError
        If the name or a parameter is unknown, a value is refused, or the algorithm cannot treat
        the problem.
    """
    complete = complete_parameters(name, parameters)
    entry = ALGORITHMS[name]
    try:
        cls = getattr(import_module(entry.module), entry.cls)
    except (ImportError, AttributeError) as error:
        raise ValueError(f"algorithm {name!r} is not in the installed pymoo: {error}") from error
    return entry.build(cls, complete, problem)


def complete_parameters(name: str, parameters: Mapping[str, Any]) -> dict[str, Any]:
    """All parameters of an algorithm: those given and the defaults of the others.

    Raises
    ------
    ValueError
        If the name or a parameter is unknown.
    """
    if not isinstance(name, str):
        raise TypeError(f"algorithm = {name!r:.80}: expected a string")
    if not isinstance(parameters, Mapping):
        raise TypeError(f"parameters = {parameters!r:.80}: expected a table")
    if name not in ALGORITHMS:
        close = difflib.get_close_matches(name, ALGORITHMS, n=1)
        suggestion = f"; did you mean {close[0]!r}?" if close else ""
        raise ValueError(
            f"no algorithm is called {name!r}: expected one of {', '.join(ALGORITHMS)}{suggestion}"
        )
    defaults = ALGORITHMS[name].defaults
    for key in parameters:
        if key not in defaults:
            raise ValueError(
                f"algorithm {name!r} has no parameter {key!r}: expected {', '.join(defaults)}"
            )
    return {**defaults, **parameters}


def default_evaluations(algorithm: Algorithm, problem: Problem) -> int:
    """What `mgeo.MGEOReal` makes by default; the same for every algorithm, so that runs compare.

    That is the paper's 5000 generations of one candidate per variable, shared by the walkers:
    59,760 for 12 variables and 30 walkers, which are also assumed where there are no walkers.
    """
    walkers = getattr(algorithm, "n_runs", 30)
    return int(max(1, EXECUTIONS // walkers) * walkers * problem.n_var)


@dataclass(frozen=True)
class _Entry:
    module: str
    cls: str
    defaults: Mapping[str, Any]
    build: Callable[[Any, Mapping[str, Any], Problem], Algorithm]


def _with_walkers(cls: Any, parameters: Mapping[str, Any], problem: Problem) -> Algorithm:
    return cls(**parameters)


def _with_population(cls: Any, parameters: Mapping[str, Any], problem: Problem) -> Algorithm:
    return cls(pop_size=_population(parameters))


def _with_directions_and_population(
    cls: Any, parameters: Mapping[str, Any], problem: Problem
) -> Algorithm:
    population = _population(parameters)
    return cls(ref_dirs=_directions(population, problem), pop_size=population)


def _with_directions(cls: Any, parameters: Mapping[str, Any], problem: Problem) -> Algorithm:
    return cls(ref_dirs=_directions(_population(parameters), problem))


def _moead(cls: Any, parameters: Mapping[str, Any], problem: Problem) -> Algorithm:
    if problem.has_constraints():
        raise ValueError("algorithm 'moead' does not treat constraints, which this problem has")
    return _with_directions(cls, parameters, problem)


def _random(cls: Any, parameters: Mapping[str, Any], problem: Problem) -> Algorithm:
    return cls(n_points_per_iteration=_population(parameters))


def _population(parameters: Mapping[str, Any]) -> int:
    return integer("population", parameters["population"], low=4, high=_MOST_POPULATION)


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


def _pymoo(
    module: str,
    cls: str,
    build: Callable[[Any, Mapping[str, Any], Problem], Algorithm] = _with_population,
) -> _Entry:
    return _Entry(f"pymoo.algorithms.{module}", cls, {"population": 100}, build)


_STEPS = {"sigma": 1.0, "tau": 3.0, "n_runs": 30, "perturbation": "absolute"}
_BITS = {"tau": 3.0, "n_runs": 30, "bits": 16, "coding": "plain"}
_RESTARTS = {"restart": "never", "patience": 50}

_DIRECTED = {
    "tau": 3.0, "n_runs": 8, "ends": 0.4, "difference": 0.5, "coupling": (0.25, 0.5),
    "widths": (0.001, 1.0), "recall": 0.3, "adopt": (0.2, 0.02), "renew": (4, 50),
    "max_candidates": 12,
}  # fmt: skip

# Runs of CMOPSO repeat with a seed because `mgeo.runs.solve.set_up` sees to it; RVEA is ours,
# because the result of pymoo's is its population, which is not a front.
ALGORITHMS: Mapping[str, _Entry] = {
    DEFAULT: _Entry("mgeo", "MGEOReal", _STEPS | _RESTARTS, _with_walkers),
    "mgeo-real2": _Entry(
        "mgeo",
        "MGEOReal2",
        _STEPS | {"n_steps": 5, "divisor": 2.0, "schedule": "factorial"} | _RESTARTS,
        _with_walkers,
    ),
    "mgeo-canonical": _Entry("mgeo", "MGEOCanonical", _BITS | _RESTARTS, _with_walkers),
    "mgeo-var": _Entry("mgeo", "MGEOVar", _BITS | _RESTARTS, _with_walkers),
    "mgeo-directed": _Entry("mgeo", "MGEODirected", _DIRECTED, _with_walkers),
    "nsga2": _pymoo("moo.nsga2", "NSGA2"),
    "nsga3": _pymoo("moo.nsga3", "NSGA3", _with_directions_and_population),
    "u-nsga3": _pymoo("moo.unsga3", "UNSGA3", _with_directions_and_population),
    "spea2": _pymoo("moo.spea2", "SPEA2"),
    "sms-emoa": _pymoo("moo.sms", "SMSEMOA"),
    "age-moea2": _pymoo("moo.age2", "AGEMOEA2"),
    "moead": _pymoo("moo.moead", "MOEAD", _moead),
    "ctaea": _pymoo("moo.ctaea", "CTAEA", _with_directions),
    "gde3": _pymoo("moo.gde3", "GDE3"),
    "nsde": _pymoo("moo.nsde", "NSDE"),
    "mopso-cd": _pymoo("moo.mopso_cd", "MOPSO_CD"),
    "cmopso": _pymoo("moo.cmopso", "CMOPSO"),
    "rvea": _Entry("mgeo.runs.rvea", "FrontRVEA", {"population": 100}, _with_directions),
    "random": _pymoo("soo.nonconvex.random_search", "RandomSearch", _random),
}
