"""Saving and resuming of MGEO runs between two generations.

`capture` returns the state of a run as arrays and JSON values; `restore` returns an algorithm that
continues the run exactly, including its random streams. `mgeo.store.checkpoint` writes the state to
files.
"""

from __future__ import annotations

import copy
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pymoo.core.algorithm import Algorithm
from pymoo.core.problem import Problem
from pymoo.core.termination import NoTermination, Termination
from pymoo.termination.max_eval import MaximumFunctionCallTermination
from pymoo.termination.max_gen import MaximumGenerationTermination
from pymoo.termination.max_time import TimeBasedTermination
from pymoo.util.misc import termination_from_tuple

from mgeo.algorithms.base import ExtremalOptimization
from mgeo.algorithms.packing import (
    Arrays,
    pack,
    pack_population,
    pack_stream,
    unpack,
    unpack_population,
    unpack_stream,
)
from mgeo.evaluation.evaluator import TolerantEvaluator
from mgeo.validation.entries import FileError

_BUDGETS: Mapping[str, tuple[type[Termination], str]] = {
    "n_gen": (MaximumGenerationTermination, "n_max_gen"),
    "n_eval": (MaximumFunctionCallTermination, "n_max_evals"),
    "time": (TimeBasedTermination, "max_time"),
}


@dataclass(frozen=True, eq=False)
class SavedState:
    """Saved state of a run, split into arrays and JSON values.

    Attributes
    ----------
    arrays : mapping of str to array
        Arrays of numbers.
    data : mapping
        All other values, as JSON values.
    source : path or str
        File that the state was read from, for messages.
    """

    arrays: Mapping[str, NDArray[Any]]
    data: Mapping[str, Any]
    source: Path | str = "the saved state"


def capture(algorithm: ExtremalOptimization) -> SavedState:
    """Return the current state of a run, so that `restore` can continue the run later.

    Call this function in a callback or after `next`. The state contains the `RunState`, the
    parameters of the algorithm and of a `TolerantEvaluator`, and the last candidates, random
    stream, counters and elapsed time of pymoo's `Algorithm`. A termination is included if it limits
    generations, evaluations or time. The problem, callback, display and history are not included.

    Parameters
    ----------
    algorithm : ExtremalOptimization
        Algorithm after `setup`.

    Returns
    -------
    SavedState

    Raises
    ------
    ValueError
        Before `setup`, between ask and tell, or if the option `archive` of pymoo is set, whose
        truncation is not repeatable.
    TypeError
        If the algorithm does not belong to the MGEO family, a parameter is not an attribute of the
        same name or not a JSON value, or `RunState` does not allow the type of a field.
    """
    name = type(algorithm).__name__
    if not isinstance(algorithm, ExtremalOptimization):
        raise TypeError(f"{name}: expected an algorithm of the MGEO family, to save its state")
    if algorithm.problem is None or algorithm._pending_designs is not None:
        raise ValueError(
            f"this {name} is not between two generations: expected an algorithm after setup() that "
            "does not wait for tell()"
        )
    if algorithm.archive is not None:
        raise ValueError(
            "the option archive of pymoo cannot be saved: expected None. The front of the "
            "algorithm itself is saved"
        )
    start_time = algorithm.start_time
    evaluator = algorithm.evaluator
    is_tolerant = isinstance(evaluator, TolerantEvaluator)
    arrays: Arrays = {}
    pack_population("pop", algorithm.pop, algorithm.problem, arrays)
    data = {
        "class": get_qualified_name(type(algorithm)),
        "parameters": _get_parameters(algorithm),
        "random_state": pack_stream(algorithm.random_state),
        "evaluations": evaluator.get_counts() if is_tolerant else {"n_eval": evaluator.n_eval},
        "elapsed_s": 0.0 if start_time is None else time.time() - start_time,
        "termination": _get_termination_arguments(algorithm.termination),
        "return_least_infeasible": bool(algorithm.return_least_infeasible),
        # An evaluator of another class must be passed to `restore`.
        "evaluator": evaluator.get_settings() if type(evaluator) is TolerantEvaluator else {},
        "state": pack("state", algorithm.state, algorithm.problem, arrays),
    }
    return SavedState(arrays, data)


def restore(
    saved_state: SavedState, problem: Problem, algorithm: Algorithm, **options: Any
) -> ExtremalOptimization:
    """Restore a saved run, and return an algorithm that continues the run.

    Parameters
    ----------
    saved_state : SavedState
        Return value of `capture`.
    problem : Problem
        Problem of the run.
    algorithm : ExtremalOptimization
        Algorithm of the class and parameters of the run, before `setup`. It is not modified.
    **options
        Options of `setup`: `callback`, `verbose`, .... A `termination` replaces the saved one; it
        is required if none was saved. The default `evaluator` is a `TolerantEvaluator` with the
        settings of the run.

    Returns
    -------
    ExtremalOptimization

    Raises
    ------
    ValueError
        If the class or a parameter of the algorithm differs from the run, the termination is
        missing or invalid, `setup` rejects the problem, or the state is damaged. In the last case
        the message begins with the `source`.
    TypeError
        If an option of `setup` is unknown.
    """
    with _convert_errors(saved_state.source):
        data = saved_state.data
        checked = _check_algorithm(algorithm, data)
        options.setdefault("evaluator", TolerantEvaluator(**data["evaluator"]))
        options.setdefault("return_least_infeasible", data["return_least_infeasible"])
        if (termination := options.pop("termination", None)) is None:
            if data["termination"] is None:
                raise ValueError("the termination of the run was not saved: expected a new one")
            termination = tuple(data["termination"])
    run = copy.deepcopy(checked)
    run.setup(problem, termination=_convert_termination(termination), **options)
    with _convert_errors(saved_state.source):
        _load_state(run, saved_state)
    if run.n_generations:
        run.is_initialized = True
        run.off = run.pop
        run._set_optimum()
        run.n_iter = run.n_generations + 1
        set_termination(run, run.termination)
    return run


def set_termination(algorithm: ExtremalOptimization, termination: Any) -> None:
    """Replace the termination criterion of a run between two generations.

    Parameters
    ----------
    algorithm : ExtremalOptimization
        Algorithm after `setup`.
    termination : Termination or tuple
        Any form that pymoo accepts, such as ``("n_gen", 200)``.

    Raises
    ------
    ValueError
        If pymoo does not accept the termination.
    """
    algorithm.termination = _convert_termination(termination)
    if algorithm.n_generations:
        # A termination is updated with the number of completed generations, as after a generation.
        algorithm.n_iter = algorithm.n_generations
        algorithm.termination.update(algorithm)
        algorithm.n_iter += 1


def get_qualified_name(cls: type) -> str:
    """Return the qualified name of a class, such as ``mgeo.algorithms.real.MGEOReal``."""
    return f"{cls.__module__}.{cls.__qualname__}"


def _get_parameters(algorithm: ExtremalOptimization) -> dict[str, Any]:
    """Return the constructor parameters as JSON values, without the initial designs."""
    name = type(algorithm).__name__
    return {
        key: _convert_to_json(f"{name}.{key}", value)
        for key, value in algorithm.get_params().items()
        if key != "sampling"  # Initial designs have no effect on the continuation.
    }


def _check_algorithm(algorithm: Algorithm, data: Mapping[str, Any]) -> ExtremalOptimization:
    """Check that an algorithm has the class and parameters of the saved run, and return it."""
    name = get_qualified_name(type(algorithm))
    if data["class"] != name or not isinstance(algorithm, ExtremalOptimization):
        raise ValueError(f"class = {data['class']!r:.80}: the algorithm given is a {name}")
    parameters = _get_parameters(algorithm)
    for key, value in data["parameters"].items():
        if parameters[key] != value:
            raise ValueError(
                f"parameters.{key} = {value!r:.80}: the algorithm given has {parameters[key]!r:.80}"
            )
    return algorithm


def _load_state(algorithm: ExtremalOptimization, saved_state: SavedState) -> None:
    data, arrays = saved_state.data, saved_state.arrays
    algorithm.random_state = unpack_stream(data["random_state"])
    algorithm.state = unpack("state", algorithm.state, data["state"], arrays, algorithm)
    algorithm.pop = unpack_population("pop", arrays, algorithm)
    if isinstance(algorithm.evaluator, TolerantEvaluator):
        algorithm.evaluator.restore_counts(data["evaluations"])
    else:
        algorithm.evaluator.n_eval = data["evaluations"]["n_eval"]
    # The saved time is negative if the system clock was set back during the run.
    algorithm.start_time = time.time() - max(0.0, data["elapsed_s"])


@contextmanager
def _convert_errors(source: Path | str) -> Iterator[None]:
    """Context manager that converts any exception to a FileError with the file name."""
    try:
        yield
    except ValueError as error:
        raise FileError(f"{source}: {error}") from error
    # A damaged state can cause any exception: NumPy does not validate the state of a generator.
    except Exception as error:
        raise FileError(
            f"{source}: the saved state is damaged: {type(error).__name__}: {error}"
        ) from error


def _convert_to_json(name: str, value: Any) -> Any:
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, list | tuple):
        return [_convert_to_json(f"{name}[{i}]", entry) for i, entry in enumerate(value)]
    if value is None or isinstance(value, bool | int | float | str):
        return value
    raise TypeError(
        f"{name} = {value!r}: expected numbers, strings or None, to save them in a file"
    )


def _get_termination_arguments(termination: Termination) -> list[Any] | None:
    """Return the arguments that recreate a pymoo termination, or None if it is not supported.

    The arguments are those of `pymoo.termination.get_termination`.
    """
    if type(termination) is NoTermination:
        return ["n_gen", None]
    for name, (cls, attribute) in _BUDGETS.items():
        if type(termination) is cls:
            return [name, _convert_to_json("termination", getattr(termination, attribute))]
    return None


def _convert_termination(termination: Any) -> Termination:
    cause = None
    try:
        converted = termination_from_tuple(copy.deepcopy(termination))
        if isinstance(converted, Termination):
            return converted
    except Exception as error:  # pymoo raises Exception itself for unknown names.
        cause = error
    raise ValueError(
        f"termination = {termination!r:.80}: expected a pymoo Termination or its arguments, such "
        "as ('n_gen', 200)"
    ) from cause
