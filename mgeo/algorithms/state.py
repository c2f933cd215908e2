"""State of a variant of MGEO between two generations, as plain data.

`capture` returns what NumPy and JSON can write, and `restore` makes an algorithm of the class and
parameters of the run that continues exactly, random streams included.
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
    """State of a run.

    Attributes
    ----------
    arrays : arrays of numbers by name.
    data : all other values, as JSON values.
    source : file that the state was read from, for messages.
    """

    arrays: Mapping[str, NDArray[Any]]
    data: Mapping[str, Any]
    source: Path | str = "the saved state"


def capture(algorithm: ExtremalOptimization) -> SavedState:
    """Return the state of a run between two generations: within a callback, or after `next`.

    The state consists of the `RunState`, the parameters, those of a `TolerantEvaluator`, and of
    pymoo's `Algorithm` the last candidates, random stream, counters and time used. The problem,
    callback, display and history are not part of it, nor is a termination that is no budget of
    generations, evaluations or time.

    Raises
    ------
    ValueError
        Before `setup`, between ask and tell, or with one of pymoo's archives, whose truncation is
        not repeatable.
    TypeError
        For an algorithm of another family, a parameter that is not kept under its name or is no
        JSON value, or a field of the state of another kind than `RunState` allows.
    """
    name = type(algorithm).__name__
    if not isinstance(algorithm, ExtremalOptimization):
        raise TypeError(f"{name} is no variant of MGEO, of which alone states are kept")
    if algorithm.problem is None or algorithm._asked is not None:
        raise ValueError(
            f"this {name} is not between two generations: expected one that was set up and does "
            "not wait for tell()"
        )
    if algorithm.archive is not None:
        raise ValueError("archive = ... cannot be kept: expected None (the front itself is kept)")
    started = algorithm.start_time
    evaluator = algorithm.evaluator
    is_tolerant = isinstance(evaluator, TolerantEvaluator)
    arrays: Arrays = {}
    pack_population("pop", algorithm.pop, algorithm.problem, arrays)
    data = {
        "class": full_name(type(algorithm)),
        "parameters": _parameters(algorithm),
        "random_state": pack_stream(algorithm.random_state),
        "evaluations": evaluator.counts() if is_tolerant else {"n_eval": evaluator.n_eval},
        "elapsed_s": 0.0 if started is None else time.time() - started,
        "termination": _budget(algorithm.termination),
        "return_least_infeasible": bool(algorithm.return_least_infeasible),
        # an evaluator of another class has to be given again
        "evaluator": evaluator.settings() if type(evaluator) is TolerantEvaluator else {},
        "state": pack("state", algorithm.state, algorithm.problem, arrays),
    }
    return SavedState(arrays, data)


def restore(
    saved: SavedState, problem: Problem, algorithm: Algorithm, **options: Any
) -> ExtremalOptimization:
    """Return a copy of an algorithm that continues where `capture` was called.

    Parameters
    ----------
    saved : what `capture` returned.
    problem : the problem of the run.
    algorithm : an algorithm of the class and parameters of the run, not set up; it is not changed.
    options : as for `setup`: `callback`, `verbose`, ...; and a `termination`, to replace that of
        the run (required if that was not kept). Without an `evaluator`, a `TolerantEvaluator`
        with the settings of the run.

    Raises
    ------
    ValueError
        If the algorithm is another one, if the termination is missing or is none, for what
        `setup` refuses, and if the state is damaged; the message begins with the `source`.
    TypeError
        For options that `setup` does not take.
    """
    with _errors_of_state(saved.source):
        data = saved.data
        same = _same(algorithm, data)
        options.setdefault("evaluator", TolerantEvaluator(**data["evaluator"]))
        options.setdefault("return_least_infeasible", data["return_least_infeasible"])
        if (termination := options.pop("termination", None)) is None:
            if data["termination"] is None:
                raise ValueError("the termination of the run was not kept: expected a new one")
            termination = tuple(data["termination"])
    run = copy.deepcopy(same)
    run.setup(problem, termination=_converted(termination), **options)
    with _errors_of_state(saved.source):
        _fill(run, saved)
    if run.n_generations:
        run.is_initialized = True
        run.off = run.pop
        run._set_optimum()
        run.n_iter = run.n_generations + 1
        end_at(run, run.termination)
    return run


def end_at(algorithm: ExtremalOptimization, termination: Any) -> None:
    """Give a run between two generations a new termination, in any form that pymoo takes."""
    algorithm.termination = _converted(termination)
    if algorithm.n_generations:
        algorithm.n_iter = algorithm.n_generations  # what a termination sees after a generation
        algorithm.termination.update(algorithm)
        algorithm.n_iter += 1


def full_name(cls: type) -> str:
    """Module and name of a class."""
    return f"{cls.__module__}.{cls.__qualname__}"


def _parameters(algorithm: ExtremalOptimization) -> dict[str, Any]:
    """What tells an algorithm from others of its class, as JSON values."""
    name = type(algorithm).__name__
    return {
        key: _plain(f"{name}.{key}", value)
        for key, value in algorithm.get_params().items()
        if key != "sampling"  # says where to start: not needed to go on
    }


def _same(algorithm: Algorithm, data: Mapping[str, Any]) -> ExtremalOptimization:
    """Return the algorithm if it is that of a saved run, else name the first difference."""
    given = full_name(type(algorithm))
    if data["class"] != given or not isinstance(algorithm, ExtremalOptimization):
        raise ValueError(f"class = {data['class']!r:.80}: the algorithm given is a {given}")
    parameters = _parameters(algorithm)
    for key, value in data["parameters"].items():
        if parameters[key] != value:
            raise ValueError(
                f"parameters.{key} = {value!r:.80}: that given has {parameters[key]!r:.80}"
            )
    return algorithm


def _fill(algorithm: ExtremalOptimization, saved: SavedState) -> None:
    """Replace what `setup` has made by what was saved."""
    data, arrays = saved.data, saved.arrays
    algorithm.random_state = unpack_stream(data["random_state"])
    algorithm.state = unpack("state", algorithm.state, data["state"], arrays, algorithm)
    algorithm.pop = unpack_population("pop", arrays, algorithm)
    if isinstance(algorithm.evaluator, TolerantEvaluator):
        algorithm.evaluator.count_on(data["evaluations"])
    else:
        algorithm.evaluator.n_eval = data["evaluations"]["n_eval"]
    # the clock may have been put back
    algorithm.start_time = time.time() - max(0.0, data["elapsed_s"])


@contextmanager
def _errors_of_state(source: Path | str) -> Iterator[None]:
    """Raise a `FileError` for whatever a damaged state leads to."""
    try:
        yield
    except ValueError as error:
        raise FileError(f"{source}: {error}") from error
    except Exception as error:  # of any kind: NumPy does not check the states of its streams
        raise FileError(
            f"{source}: the saved state is damaged: {type(error).__name__}: {error}"
        ) from error


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


def _converted(termination: Any) -> Termination:
    cause = None
    try:
        converted = termination_from_tuple(copy.deepcopy(termination))
        if isinstance(converted, Termination):
            return converted
    except Exception as error:  # pymoo raises Exception itself for a name that it does not know
        cause = error
    raise ValueError(
        f"termination = {termination!r:.80}: expected a pymoo Termination, or what stands for one, "
        "such as ('n_gen', 200)"
    ) from cause
