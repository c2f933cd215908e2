"""What a run carries, value by value, as arrays of numbers and JSON values, and back."""

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pymoo.core.population import Population
from pymoo.core.problem import Problem

from mgeo.algorithms.archive import ParetoArchive
from mgeo.algorithms.base import ExtremalOptimization
from mgeo.evaluation.individuals import as_numbers
from mgeo.validation.entries import entry

Arrays = Mapping[str, NDArray[Any]]

_VALUES = ("X", "F", "G", "H", "CV", "n_gen")
_GENERATORS = {cls.__name__: cls for cls in (np.random.PCG64, np.random.PCG64DXSM)}


def pack(name: str, value: Any, problem: Problem) -> tuple[dict[str, NDArray[Any]], Any]:
    """A field of a `RunState`, called `name`: arrays by name, and a JSON value.

    TypeError for a value of a kind that `RunState` does not allow.
    """
    if isinstance(value, np.ndarray) and not value.dtype.hasobject:
        return {name: value.copy()}, None
    if isinstance(value, np.random.Generator):
        return {}, pack_stream(value)
    if isinstance(value, list) and all(isinstance(each, np.random.Generator) for each in value):
        return {}, [pack_stream(each) for each in value]
    if isinstance(value, ParetoArchive):
        counts = {"violation": value.violation, "n_rejected": value.n_rejected}
        arrays = {f"{name}.{key}": np.array(count) for key, count in counts.items()}
        return arrays | pack_population(name, value.individuals, problem), None
    if is_dataclass(value) and not isinstance(value, type):
        parts = {f.name: getattr(value, f.name) for f in fields(value)}
        packed = {key: pack(f"{name}.{key}", part, problem) for key, part in parts.items()}
        found = {key: array for arrays, _ in packed.values() for key, array in arrays.items()}
        return found, {key: values for key, (_, values) in packed.items()}
    plain = value.item() if isinstance(value, np.generic) else value
    if isinstance(plain, bool | int | float | str):
        return {}, plain
    raise TypeError(
        f"{name} = {value!r:.80}: expected an array of numbers, random streams, an archive, a "
        "number, text or a dataclass of these"
    )


def unpack(
    name: str, arrays: Arrays, values: Any, fresh: Any, algorithm: ExtremalOptimization
) -> Any:
    """The field that was packed, of the kind and shape that `fresh` has in a run that begins.

    TypeError or ValueError if it is missing, or of another kind or shape.
    """
    if isinstance(fresh, np.ndarray):
        return _array(arrays, name, fresh.shape).astype(fresh.dtype)
    if isinstance(fresh, ParetoArchive):
        archive = ParetoArchive(fresh.F.shape[1], fresh.max_size)
        archive.individuals = unpack_population(name, arrays, algorithm)
        archive.F = archive.individuals.get("F").reshape(-1, fresh.F.shape[1])
        archive.violation = float(_array(arrays, f"{name}.violation", ()))
        archive.n_rejected = int(_array(arrays, f"{name}.n_rejected", ()))
        if not np.isfinite(archive.F).all():
            raise ValueError(f"{name}: expected finite objectives")
        return archive
    where, _, key = name.rpartition(".")
    if isinstance(fresh, np.random.Generator):
        return unpack_stream(entry(values, key, dict, f"{where}."))
    if is_dataclass(fresh) and not isinstance(fresh, type):
        if key not in values:  # of an older version, without it: as where a run begins
            return fresh
        of_it = entry(values, key, dict, f"{where}.")
        parts = {
            f.name: unpack(f"{name}.{f.name}", arrays, of_it, getattr(fresh, f.name), algorithm)
            for f in fields(fresh)
        }
        return type(fresh)(**parts)
    packed = entry(values, key, type(fresh), f"{where}.")
    if not isinstance(fresh, list):
        return packed
    if len(packed) != len(fresh):
        raise ValueError(f"{name}: {len(packed)} streams, expected {len(fresh)}")
    return [unpack_stream(state) for state in packed]


def pack_stream(stream: np.random.Generator) -> dict[str, Any]:
    """The state of a random stream as JSON values; TypeError for one of another kind."""
    bits = stream.bit_generator
    seed = bits.seed_seq  # counts the streams spawned from this one
    if type(bits).__name__ not in _GENERATORS or not isinstance(seed, np.random.SeedSequence):
        raise TypeError(f"{bits!r}: expected one of {', '.join(_GENERATORS)}, to keep its state")
    return {"bits": bits.state, "seed": seed.state}


def unpack_stream(state: Mapping[str, Any]) -> np.random.Generator:
    """The random stream of such a state; ValueError if it is none."""
    try:
        bits = _GENERATORS[state["bits"]["bit_generator"]](np.random.SeedSequence(**state["seed"]))
        bits.state = state["bits"]
    except Exception as error:  # of many kinds: NumPy does not check what it is given
        raise ValueError(f"no state of a random stream: {type(error).__name__}: {error}") from error
    return np.random.Generator(bits)


def pack_population(
    prefix: str, population: Population | None, problem: Problem
) -> dict[str, NDArray[Any]]:
    """The arrays of evaluated individuals; none if there are none."""
    if population is None or not len(population):
        return {}
    columns = dict(zip(_VALUES, population.get(*_VALUES), strict=True))
    columns["X"] = as_numbers(problem, columns["X"])
    return {f"{prefix}_{key}": column for key, column in columns.items() if column.dtype != object}


def unpack_population(prefix: str, arrays: Arrays, algorithm: ExtremalOptimization) -> Population:
    """Individuals of such arrays; ValueError if one is missing or has another shape."""
    given = {key: arrays[f"{prefix}_{key}"] for key in _VALUES if f"{prefix}_{key}" in arrays}
    if given:
        problem = algorithm.problem
        n = len(np.atleast_1d(_array(arrays, f"{prefix}_X")))
        shapes = {"X": (n, problem.n_var), "F": (n, problem.n_obj), "G": (n, problem.n_ieq_constr),
                  "H": (n, problem.n_eq_constr), "CV": (n, 1)}  # fmt: skip
        for key in {**shapes, **given}:
            _array(arrays, f"{prefix}_{key}", shapes.get(key, (n,)))
        if algorithm.variables.names is not None:
            given["X"] = algorithm.variables.designs(given["X"])
    population: Population = Population.new(**given)
    for individual in population:
        individual.evaluated = {"F", "G", "H"}
    return population


def _array(arrays: Arrays, name: str, shape: tuple[int, ...] | None = None) -> NDArray[Any]:
    if name not in arrays:
        raise ValueError(f"{name} is missing from the saved state")
    if shape is not None and arrays[name].shape != shape:
        raise ValueError(f"{name} of shape {arrays[name].shape}: expected {shape}")
    return arrays[name]
