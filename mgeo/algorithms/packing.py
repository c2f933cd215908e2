"""Conversion of the state of a run to arrays and JSON values, and back.

`mgeo.algorithms.state` builds on these functions.
"""

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pymoo.core.population import Population
from pymoo.core.problem import Problem

from mgeo.algorithms.archive import ParetoArchive
from mgeo.algorithms.base import ExtremalOptimization
from mgeo.evaluation.individuals import convert_designs_to_numbers

Arrays = dict[str, NDArray[Any]]

_VALUES = ("X", "F", "G", "H", "CV", "n_gen")
_BIT_GENERATORS = {cls.__name__: cls for cls in (np.random.PCG64, np.random.PCG64DXSM)}


def pack(name: str, value: Any, problem: Problem, arrays: Arrays) -> Any:
    """Split a field of a run's state into a JSON value and arrays.

    Parameters
    ----------
    name : str
        Prefix of the names of the arrays.
    value : object
        Field of a `RunState`.
    problem : Problem
    arrays : dict of str to array
        Receives the arrays of the value.

    Returns
    -------
    JSON value
        All of `value` except its arrays, for `unpack`.

    Raises
    ------
    TypeError
        If `RunState` does not allow the type of the value.
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
        # The violation is stored as an array, because JSON has no infinity.
        arrays[f"{name}.violation"] = np.array(value.violation)
        return value.n_rejected
    if is_dataclass(value):
        return {
            field.name: pack(f"{name}.{field.name}", getattr(value, field.name), problem, arrays)
            for field in fields(value)
        }
    scalar = value.item() if isinstance(value, np.generic) else value
    if isinstance(scalar, bool | int | float | str):
        return scalar
    raise TypeError(
        f"{name} = {value!r:.80}: expected an array of numbers, a random stream, an archive, a "
        "number, a string, or a list or dataclass of these"
    )


def unpack(
    name: str,
    template: Any,
    packed: Any,
    arrays: Mapping[str, Any],
    algorithm: ExtremalOptimization,
) -> Any:
    """Restore a field of a run's state from the output of `pack`.

    Parameters
    ----------
    name : str
        Name that was passed to `pack`.
    template : object
        Value of the same type and shape, from an algorithm after `setup`.
    packed : JSON value
        Return value of `pack`.
    arrays : mapping of str to array
        Arrays that `pack` has added.
    algorithm : ExtremalOptimization
        Algorithm after `setup`.

    Raises
    ------
    KeyError, TypeError, ValueError
        If a part is missing, or has another type or shape than in `template`.
    """
    if isinstance(template, np.ndarray):
        if arrays[name].shape != template.shape:
            raise ValueError(f"{name} of shape {arrays[name].shape}: expected {template.shape}")
        return arrays[name].astype(template.dtype)
    if isinstance(template, np.random.Generator):
        return unpack_stream(packed)
    if isinstance(template, list):
        return [
            unpack(f"{name}[{i}]", each, part, arrays, algorithm)
            for i, (each, part) in enumerate(zip(template, packed, strict=True))
        ]
    if isinstance(template, ParetoArchive):
        archive = ParetoArchive(template.F.shape[1], template.max_size)
        archive.individuals = unpack_population(name, arrays, algorithm)
        archive.F = archive.individuals.get("F").reshape(-1, template.F.shape[1])
        archive.violation = float(arrays[f"{name}.violation"])
        archive.n_rejected = int(packed)
        return archive
    if is_dataclass(template) and not isinstance(template, type):
        parts = {
            field.name: unpack(
                f"{name}.{field.name}",
                getattr(template, field.name),
                packed[field.name],
                arrays,
                algorithm,
            )
            for field in fields(template)
        }
        return type(template)(**parts)
    return type(template)(packed)


def pack_stream(stream: np.random.Generator) -> dict[str, Any]:
    """Return the state of a random number generator as a dict of JSON values.

    Raises
    ------
    TypeError
        If the bit generator is neither PCG64 nor PCG64DXSM.
    """
    bits = stream.bit_generator
    seed = bits.seed_seq  # The seed sequence is stored, because it counts the spawned streams.
    if type(bits).__name__ not in _BIT_GENERATORS or not isinstance(seed, np.random.SeedSequence):
        raise TypeError(
            f"{bits!r}: expected one of {', '.join(_BIT_GENERATORS)}, to save its state"
        )
    return {"bits": bits.state, "seed": seed.state}


def unpack_stream(state: Mapping[str, Any]) -> np.random.Generator:
    """Create a random number generator from a state that `pack_stream` returned."""
    bits = _BIT_GENERATORS[state["bits"]["bit_generator"]](np.random.SeedSequence(**state["seed"]))
    bits.state = state["bits"]
    return np.random.Generator(bits)


def pack_population(
    name: str, population: Population | None, problem: Problem, arrays: Arrays
) -> None:
    """Add the designs, objectives and constraint values of a population to a dict of arrays.

    Parameters
    ----------
    name : str
        Prefix of the keys, as in ``NAME_X`` and ``NAME_F``.
    population : Population or None
        Individuals. No arrays are added for None or an empty population.
    problem : Problem
    arrays : dict of str to array
        Receives the arrays.
    """
    if population is None or not len(population):
        return
    columns = dict(zip(_VALUES, population.get(*_VALUES), strict=True))
    columns["X"] = convert_designs_to_numbers(problem, columns["X"])
    for key, column in columns.items():
        if column.dtype != object:
            arrays[f"{name}_{key}"] = column


def unpack_population(
    name: str, arrays: Mapping[str, Any], algorithm: ExtremalOptimization
) -> Population:
    """Restore a population from the arrays that `pack_population` stored.

    Raises
    ------
    ValueError
        If the arrays have different lengths.
    """
    columns = {key: arrays[f"{name}_{key}"] for key in _VALUES if f"{name}_{key}" in arrays}
    if len({len(column) for column in columns.values()}) > 1:
        raise ValueError(f"{name}: expected the same number of rows in {', '.join(columns)}")
    if columns and algorithm.variables.names is not None:
        columns["X"] = algorithm.variables.to_designs(columns["X"])
    population: Population = Population.new(**columns)
    for individual in population:
        individual.evaluated = {"F", "G", "H"}
    return population
