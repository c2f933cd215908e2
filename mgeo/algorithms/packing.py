"""Conversion of the state of a run to arrays and JSON values, and back."""

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

Arrays = dict[str, NDArray[Any]]

_VALUES = ("X", "F", "G", "H", "CV", "n_gen")
_GENERATORS = {cls.__name__: cls for cls in (np.random.PCG64, np.random.PCG64DXSM)}


def pack(name: str, value: Any, problem: Problem, arrays: Arrays) -> Any:
    """Add the arrays of a value to `arrays`, and return the rest as a JSON value.

    Raises
    ------
    TypeError
        For a value of a kind that `RunState` does not allow.
    """
    if isinstance(value, np.ndarray) and not value.dtype.hasobject:
        arrays[name] = value.copy()
        return None
    if isinstance(value, np.random.Generator):
        return pack_stream(value)
    if isinstance(value, list):
        return [pack(f"{name}[{i}]", each, problem, arrays) for i, each in enumerate(value)]
    if isinstance(value, ParetoArchive):
        pack_population(name, value.individuals, problem, arrays)
        arrays[f"{name}.violation"] = np.array(value.violation)  # may be infinite
        return value.n_rejected
    if is_dataclass(value):
        return {
            field.name: pack(f"{name}.{field.name}", getattr(value, field.name), problem, arrays)
            for field in fields(value)
        }
    plain = value.item() if isinstance(value, np.generic) else value
    if isinstance(plain, bool | int | float | str):
        return plain
    raise TypeError(
        f"{name} = {value!r:.80}: expected an array of numbers, a random stream, an archive, a "
        "number, text, or a list or dataclass of these"
    )


def unpack(
    name: str, fresh: Any, packed: Any, arrays: Mapping[str, Any], algorithm: ExtremalOptimization
) -> Any:
    """Return the value that `pack` took apart, of the kind and shape of `fresh`.

    Raises
    ------
    KeyError, TypeError, ValueError
        If a part is missing, or of another kind or shape.
    """
    if isinstance(fresh, np.ndarray):
        if arrays[name].shape != fresh.shape:
            raise ValueError(f"{name} of shape {arrays[name].shape}: expected {fresh.shape}")
        return arrays[name].astype(fresh.dtype)
    if isinstance(fresh, np.random.Generator):
        return unpack_stream(packed)
    if isinstance(fresh, list):
        return [
            unpack(f"{name}[{i}]", each, part, arrays, algorithm)
            for i, (each, part) in enumerate(zip(fresh, packed, strict=True))
        ]
    if isinstance(fresh, ParetoArchive):
        archive = ParetoArchive(fresh.F.shape[1], fresh.max_size)
        archive.individuals = unpack_population(name, arrays, algorithm)
        archive.F = archive.individuals.get("F").reshape(-1, fresh.F.shape[1])
        archive.violation = float(arrays[f"{name}.violation"])
        archive.n_rejected = int(packed)
        return archive
    if is_dataclass(fresh) and not isinstance(fresh, type):
        parts = {
            field.name: unpack(
                f"{name}.{field.name}",
                getattr(fresh, field.name),
                packed[field.name],
                arrays,
                algorithm,
            )
            for field in fields(fresh)
        }
        return type(fresh)(**parts)
    return type(fresh)(packed)


def pack_stream(stream: np.random.Generator) -> dict[str, Any]:
    """Return the state of a random stream as JSON values, for `unpack_stream`.

    Raises
    ------
    TypeError
        For a generator of another kind than PCG64.
    """
    bits = stream.bit_generator
    seed = bits.seed_seq  # counts the streams spawned from this one
    if type(bits).__name__ not in _GENERATORS or not isinstance(seed, np.random.SeedSequence):
        raise TypeError(f"{bits!r}: expected one of {', '.join(_GENERATORS)}, to keep its state")
    return {"bits": bits.state, "seed": seed.state}


def unpack_stream(state: Mapping[str, Any]) -> np.random.Generator:
    """Return the random stream of a state."""
    bits = _GENERATORS[state["bits"]["bit_generator"]](np.random.SeedSequence(**state["seed"]))
    bits.state = state["bits"]
    return np.random.Generator(bits)


def pack_population(
    name: str, population: Population | None, problem: Problem, arrays: Arrays
) -> None:
    """Add the arrays of evaluated individuals to `arrays`; none if there are no individuals."""
    if population is None or not len(population):
        return
    columns = dict(zip(_VALUES, population.get(*_VALUES), strict=True))
    columns["X"] = as_numbers(problem, columns["X"])
    for key, column in columns.items():
        if column.dtype != object:
            arrays[f"{name}_{key}"] = column


def unpack_population(
    name: str, arrays: Mapping[str, Any], algorithm: ExtremalOptimization
) -> Population:
    """Return the individuals of such arrays.

    Raises
    ------
    ValueError
        If the arrays have different lengths.
    """
    columns = {key: arrays[f"{name}_{key}"] for key in _VALUES if f"{name}_{key}" in arrays}
    if len({len(column) for column in columns.values()}) > 1:
        raise ValueError(f"{name}: expected as many rows in each of {', '.join(columns)}")
    if columns and algorithm.variables.names is not None:
        columns["X"] = algorithm.variables.designs(columns["X"])
    population: Population = Population.new(**columns)
    for individual in population:
        individual.evaluated = {"F", "G", "H"}
    return population
