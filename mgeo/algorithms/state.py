"""The complete state of a member of the family between two generations, as plain data.

What `capture` returns can be written with NumPy and JSON alone, and `restore` makes of it an
algorithm that goes on as if it had never stopped, random streams included.
"""

from __future__ import annotations

import copy
import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pymoo.core.evaluator import Evaluator
from pymoo.core.population import Population
from pymoo.core.problem import Problem
from pymoo.core.termination import NoTermination, Termination
from pymoo.termination.max_eval import MaximumFunctionCallTermination
from pymoo.termination.max_gen import MaximumGenerationTermination
from pymoo.termination.max_time import TimeBasedTermination
from pymoo.util.misc import termination_from_tuple

from mgeo.algorithms.base import ExtremalOptimization
from mgeo.algorithms.parameters import integer
from mgeo.designs import as_numbers
from mgeo.evaluation import TolerantEvaluator
from mgeo.reading import entry

_START_ONLY = ("sampling",)  # parameters that say where to begin: not needed to go on
_VALUES = ("X", "F", "G", "H", "CV", "n_gen")
_GENERATORS = {cls.__name__: cls for cls in (np.random.PCG64, np.random.PCG64DXSM)}
_BUDGETS: Mapping[str, tuple[type[Termination], str]] = {
    "n_gen": (MaximumGenerationTermination, "n_max_gen"),
    "n_eval": (MaximumFunctionCallTermination, "n_max_evals"),
    "time": (TimeBasedTermination, "max_time"),
}


@dataclass(frozen=True, eq=False)
class SavedState:
    """Arrays of numbers by name, and what else there is as JSON values."""

    arrays: Mapping[str, NDArray[Any]]
    data: Mapping[str, Any]


def capture(algorithm: ExtremalOptimization) -> SavedState:
    """The state of a run between two generations: within a callback, or after `next`.

    It holds the arrays that the class names in `_state_arrays`, the archive, the last candidates,
    every random stream, the counters, the time used and the parameters. Not in it: the problem,
    callback, display and history, and a termination that is no budget of generations,
    evaluations or time.

    Raises
    ------
    ValueError : before `setup`, between ask and tell, or with one of pymoo's archives, whose
        truncation does not repeat.
    TypeError : for an algorithm of another family, a class that cannot be made again from its
        parameters, a parameter that is no JSON value, or a named attribute that is no array.
    """
    name = type(algorithm).__name__
    if not isinstance(algorithm, ExtremalOptimization):
        raise TypeError(f"{name} is no member of the MGEO family, of which alone states are kept")
    if algorithm.problem is None:
        raise ValueError(f"this {name} has no state yet: expected one that was set up")
    if algorithm._asked is not None:
        raise ValueError(f"this {name} waits for tell(): expected one between two generations")
    if algorithm.archive is not None:
        raise ValueError("archive = ... cannot be kept: expected None (the front itself is kept)")
    started = algorithm.start_time
    data = {
        "class": _full_name(type(algorithm)),
        "parameters": {
            key: _plain(f"{name}.{key}", value)
            for key, value in algorithm._parameters.items()
            if key not in _START_ONLY
        },
        "streams": [_stream_state(stream) for stream in algorithm.streams],
        "random_state": _stream_state(algorithm.random_state),
        "generations": algorithm.n_generations,
        "evaluations": _counts(algorithm.evaluator),
        "elapsed_s": 0.0 if started is None else time.time() - started,
        "termination": _budget(algorithm.termination),
        "return_least_infeasible": bool(algorithm.return_least_infeasible),
    }
    front = algorithm.front
    arrays = {
        "front_violation": np.array(front.violation),
        "front_n_rejected": np.array(front.n_rejected),
        **_population_arrays("front", front.individuals, algorithm.problem),
        **_population_arrays("pop", algorithm.pop, algorithm.problem),
    }
    for key in algorithm._state_arrays:
        value = getattr(algorithm, key)
        if not isinstance(value, np.ndarray) or value.dtype.hasobject:
            raise TypeError(f"{name}.{key} = {value!r}: expected an array of numbers")
        arrays[f"own_{key}"] = value.copy()
    return SavedState(arrays, data)


def restore(saved: SavedState, problem: Problem, **options: Any) -> ExtremalOptimization:
    """An algorithm that goes on where `capture` was called.

    Parameters
    ----------
    saved : what `capture` gave.
    problem : the same problem.
    options : as for `setup`: `callback`, `verbose`, ...; and a `termination`, if another one
        than the run had (always, if that is not kept).

    Raises
    ------
    ValueError : if the class is not known, the termination is missing, or a part of the state
        is missing or does not fit.
    """
    data, arrays = saved.data, saved.arrays
    algorithm = _find(entry(data, "class", str))(**entry(data, "parameters", dict))
    if (termination := options.pop("termination", None)) is None:
        termination = _termination(data.get("termination"))
    least = entry(data, "return_least_infeasible", bool)
    options = {"return_least_infeasible": least, **options}
    algorithm.setup(problem, termination=termination, **options)
    algorithm.random_state = _stream(entry(data, "random_state", dict))
    states = entry(data, "streams", list)
    if len(states) != len(algorithm.streams):
        raise ValueError(f"{len(states)} streams: expected {len(algorithm.streams)}")
    algorithm.streams = [_stream(state) for state in states]
    for key in algorithm._state_arrays:
        fresh = getattr(algorithm, key)
        setattr(algorithm, key, _array(arrays, f"own_{key}", fresh.shape).copy())
    if not np.isfinite(algorithm.walkers).all():
        raise ValueError("own_walkers: expected finite numbers")
    front = algorithm.front
    front.individuals = _population("front", arrays, algorithm)
    front.F = front.individuals.get("F").reshape(-1, problem.n_obj)
    front.violation = float(_array(arrays, "front_violation", ()))
    front.n_rejected = int(_array(arrays, "front_n_rejected", ()))
    algorithm.pop = _population("pop", arrays, algorithm)
    algorithm.n_generations = integer("generations", entry(data, "generations", int), low=0)
    _count_on(algorithm.evaluator, entry(data, "evaluations", dict))
    # a clock that was put back meanwhile must not make a run of less than no time
    algorithm.start_time = time.time() - max(0.0, entry(data, "elapsed_s", float))
    if algorithm.n_generations:
        algorithm.is_initialized = True
        algorithm.off = algorithm.pop
        algorithm._set_optimum()
        algorithm.n_iter = algorithm.n_generations + 1
        end_at(algorithm, algorithm.termination)
    return algorithm


def end_at(algorithm: ExtremalOptimization, termination: Any) -> None:
    """Give a run between two generations a new termination, in any form that pymoo takes."""
    algorithm.termination = termination_from_tuple(copy.deepcopy(termination))
    if algorithm.n_generations:
        algorithm.n_iter = algorithm.n_generations  # what a termination sees after a generation
        algorithm.termination.update(algorithm)
        algorithm.n_iter += 1


def _counts(evaluator: Evaluator) -> dict[str, Any]:
    if isinstance(evaluator, TolerantEvaluator):
        return evaluator.counts()
    return {"n_eval": evaluator.n_eval}


def _count_on(evaluator: Evaluator, counts: Mapping[str, Any]) -> None:
    integer("evaluations.n_eval", entry(counts, "n_eval", int, "evaluations."), low=0)
    for key, kind in (("n_failed", int), ("n_in_a_row", int), ("causes", dict[str, int])):
        if key in counts:
            entry(counts, key, kind, "evaluations.")
    if isinstance(evaluator, TolerantEvaluator):
        evaluator.count_on(counts)
    else:
        evaluator.n_eval = counts["n_eval"]


def _full_name(cls: type) -> str:
    return f"{cls.__module__}.{cls.__qualname__}"


def _find(full_name: str) -> type[ExtremalOptimization]:
    # only what is imported already: a file must not be able to import or to run anything
    known: list[type[ExtremalOptimization]] = ExtremalOptimization.__subclasses__()
    for cls in known:
        known += cls.__subclasses__()
    for cls in reversed(known):
        if _full_name(cls) == full_name:
            return cls
    raise ValueError(f"{full_name} is no imported member of the family: import its module first")


def _plain(name: str, value: Any) -> Any:
    """A parameter as a JSON value."""
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, list | tuple):
        return [_plain(f"{name}[{i}]", entry) for i, entry in enumerate(value)]
    if value is None or isinstance(value, bool | int | float | str):
        return value
    raise TypeError(f"{name} = {value!r}: expected numbers, text or None, to keep them in a file")


def _budget(termination: Termination) -> list[Any] | None:
    """As `pymoo.termination.get_termination` takes it; None for what is not kept."""
    if type(termination) is NoTermination:
        return ["n_gen", None]
    for name, (cls, attribute) in _BUDGETS.items():
        if type(termination) is cls:
            return [name, _plain("termination", getattr(termination, attribute))]
    return None


def _termination(budget: list[Any] | None) -> tuple[str, Any]:
    if budget is None:
        raise ValueError(
            "termination = None: the one of the saved run could not be kept; expected a new one"
        )
    if not (isinstance(budget, list) and len(budget) == 2 and budget[0] in _BUDGETS):
        raise ValueError(f"termination = {budget!r:.80}: expected one of {', '.join(_BUDGETS)}")
    name, limit = budget
    return name, limit


def _stream_state(stream: np.random.Generator) -> dict[str, Any]:
    bits = stream.bit_generator
    seed = bits.seed_seq  # counts the streams spawned from this one
    if type(bits).__name__ not in _GENERATORS or not isinstance(seed, np.random.SeedSequence):
        raise TypeError(f"{bits!r}: expected one of {', '.join(_GENERATORS)}, to keep its state")
    return {"bits": bits.state, "seed": seed.state}


def _stream(state: Mapping[str, Any]) -> np.random.Generator:
    try:
        bits = _GENERATORS[state["bits"]["bit_generator"]](np.random.SeedSequence(**state["seed"]))
        bits.state = state["bits"]
    except Exception as error:  # of many kinds: NumPy does not check what it is given
        raise ValueError(f"no state of a random stream: {type(error).__name__}: {error}") from error
    return np.random.Generator(bits)


def _array(
    arrays: Mapping[str, NDArray[Any]], name: str, shape: tuple[int, ...] | None = None
) -> NDArray[Any]:
    if name not in arrays:
        raise ValueError(f"{name} is missing from the saved state")
    if shape is not None and arrays[name].shape != shape:
        raise ValueError(f"{name} of shape {arrays[name].shape}: expected {shape}")
    return arrays[name]


def _population_arrays(
    prefix: str, population: Population | None, problem: Problem
) -> dict[str, NDArray[Any]]:
    if population is None or not len(population):
        return {}
    columns = dict(zip(_VALUES, population.get(*_VALUES), strict=True))
    columns["X"] = as_numbers(problem, columns["X"])
    return {f"{prefix}_{key}": column for key, column in columns.items() if column.dtype != object}


def _population(
    prefix: str, arrays: Mapping[str, NDArray[Any]], algorithm: ExtremalOptimization
) -> Population:
    given = {key: arrays[f"{prefix}_{key}"] for key in _VALUES if f"{prefix}_{key}" in arrays}
    problem, variables = algorithm.problem, algorithm.variables
    if given:
        n = len(np.atleast_1d(_array(arrays, f"{prefix}_X")))
        widths = {"X": problem.n_var, "F": problem.n_obj, "G": problem.n_ieq_constr,
                  "H": problem.n_eq_constr, "CV": 1}  # fmt: skip
        for key in {*widths, *given}:
            shape = (n, widths[key]) if key in widths else (n,)
            _array(arrays, f"{prefix}_{key}", shape)
        if prefix == "front" and not np.isfinite(given["F"]).all():
            raise ValueError("front_F: expected finite numbers")
    if given and variables.names is not None:
        given["X"] = variables.designs(given["X"])
    population: Population = Population.new(**given)
    for individual in population:
        individual.evaluated = {"F", "G", "H"}
    return population
