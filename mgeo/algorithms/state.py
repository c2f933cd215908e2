"""The complete state of a variant of MGEO between two generations, as plain data.

What `capture` returns can be written with NumPy and JSON alone, and `restore` lets an algorithm of
the same class and parameters go on from it as if it had never stopped, random streams included.
"""

from __future__ import annotations

import copy
import time
from collections.abc import Mapping
from dataclasses import dataclass, fields
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
    pack,
    pack_population,
    pack_stream,
    unpack,
    unpack_population,
    unpack_stream,
)
from mgeo.evaluation.evaluator import TolerantEvaluator
from mgeo.validation.arguments import validate_integer
from mgeo.validation.entries import entry, errors_of

_BUDGETS: Mapping[str, tuple[type[Termination], str]] = {
    "n_gen": (MaximumGenerationTermination, "n_max_gen"),
    "n_eval": (MaximumFunctionCallTermination, "n_max_evals"),
    "time": (TimeBasedTermination, "max_time"),
}


@dataclass(frozen=True, eq=False)
class SavedState:
    """Arrays of numbers by name, and what else there is as JSON values.

    `source` is what errors in them are said to be in: the file that they were read from.
    """

    arrays: Mapping[str, NDArray[Any]]
    data: Mapping[str, Any]
    source: Path | str = "the saved state"


def capture(algorithm: ExtremalOptimization) -> SavedState:
    """The state of a run between two generations: within a callback, or after `next`.

    It holds all of the algorithm's `RunState` and what pymoo carries: the last candidates, its
    random stream, the counters, the time used; and the parameters, those of a `TolerantEvaluator`
    too. Not in it: the problem,
    callback, display and history, and a termination that is no budget of generations,
    evaluations or time.

    Raises
    ------
    ValueError : before `setup`, between ask and tell, or with one of pymoo's archives, whose
        truncation does not repeat.
    TypeError : for an algorithm of another family, a parameter that is not kept under its name or
        is no JSON value, or a state with anything else than `RunState` says.
    """
    name = type(algorithm).__name__
    if not isinstance(algorithm, ExtremalOptimization):
        raise TypeError(f"{name} is no variant of MGEO, of which alone states are kept")
    if algorithm.problem is None:
        raise ValueError(f"this {name} has no state yet: expected one that was set up")
    if algorithm._asked is not None:
        raise ValueError(f"this {name} waits for tell(): expected one between two generations")
    if algorithm.archive is not None:
        raise ValueError("archive = ... cannot be kept: expected None (the front itself is kept)")
    started = algorithm.start_time
    data = {
        "class": full_name(type(algorithm)),
        "parameters": _parameters(algorithm),
        "random_state": pack_stream(algorithm.random_state),
        "evaluations": (
            algorithm.evaluator.counts()
            if isinstance(algorithm.evaluator, TolerantEvaluator)
            else {"n_eval": algorithm.evaluator.n_eval}
        ),
        "elapsed_s": 0.0 if started is None else time.time() - started,
        "termination": _budget(algorithm.termination),
        "return_least_infeasible": bool(algorithm.return_least_infeasible),
    }
    if type(algorithm.evaluator) is TolerantEvaluator:  # others the caller has to give again
        data["evaluator"] = algorithm.evaluator.settings()
    arrays = pack_population("pop", algorithm.pop, algorithm.problem)
    state, values = algorithm.state, dict[str, Any]()
    names = [field.name for field in fields(state)]
    if undeclared := sorted(getattr(state, "__dict__", {}).keys() - names):
        raise TypeError(f"{name}.state.{undeclared[0]} is no declared field of {type(state)}")
    for key in names:
        found, values[key] = pack(f"state.{key}", getattr(state, key), algorithm.problem)
        arrays |= found
    return SavedState(arrays, {**data, "state": values})


def restore(
    saved: SavedState, problem: Problem, algorithm: Algorithm, **options: Any
) -> ExtremalOptimization:
    """A copy of an algorithm that goes on where `capture` was called.

    Parameters
    ----------
    saved : what `capture` gave.
    problem : the same problem.
    algorithm : one of the same class and parameters, not set up; it is left as it is.
    options : as for `setup`: `callback`, `verbose`, ...; and a `termination`, if another one
        than the run had (always, if that is not kept). Without an `evaluator` it is a
        `TolerantEvaluator` with the settings of the run's, if that was one.

    Raises
    ------
    ValueError : if the algorithm is another one, the termination is missing, or a part of the
        state is missing or does not fit; it begins with the `source`. Also for a termination that
        is none, and for what `setup` refuses: these are not the source's.
    TypeError : for options that `setup` does not take.
    """
    with errors_of(saved.source):
        data = saved.data
        same = _same(algorithm, data)
        least = entry(data, "return_least_infeasible", bool)
        options.setdefault("evaluator", _evaluator(data.get("evaluator", {})))
        if (termination := options.pop("termination", None)) is None:
            termination = _termination(data.get("termination"))
    termination = _converted(termination)
    options = {"return_least_infeasible": least, **options}
    run = copy.deepcopy(same)
    run.setup(problem, termination=termination, **options)
    with errors_of(saved.source):
        _fill(run, saved)
    if run.n_generations:
        run.is_initialized = True
        run.off = run.pop
        run._set_optimum()
        run.n_iter = run.n_generations + 1
        end_at(run, run.termination)
    return run


def _evaluator(settings: Any) -> TolerantEvaluator:
    kinds = {
        "patience": int,
        "warn": bool,
        "skip_already_evaluated": bool,
        "evaluate_values_of": list[str],
    }
    given = {
        key: entry(settings, key, kind, "evaluator.")
        for key, kind in kinds.items()
        if key in settings
    }
    if unknown := set(given.get("evaluate_values_of", ())) - {"F", "G", "H"}:
        raise ValueError(f"evaluator.evaluate_values_of = {min(unknown)!r:.80}: expected F, G, H")
    return TolerantEvaluator(**given)


def _fill(algorithm: ExtremalOptimization, saved: SavedState) -> None:
    """Let what was saved take the place of what `setup` has made."""
    data, arrays = saved.data, saved.arrays
    algorithm.random_state = unpack_stream(entry(data, "random_state", dict))
    state, values = algorithm.state, entry(data, "state", dict)
    for field in fields(state):
        fresh = getattr(state, field.name)
        value = unpack(f"state.{field.name}", arrays, values, fresh, algorithm)
        setattr(state, field.name, value)
    if not np.isfinite(state.walkers).all():
        raise ValueError("state.walkers: expected finite numbers")
    validate_integer("state.n_generations", state.n_generations, low=0)
    algorithm.pop = unpack_population("pop", arrays, algorithm)
    counts, where = entry(data, "evaluations", dict), "evaluations."
    validate_integer("evaluations.n_eval", entry(counts, "n_eval", int, where), low=0)
    for key, kind in (("n_failed", int), ("n_in_a_row", int), ("causes", dict[str, int])):
        if key in counts:
            entry(counts, key, kind, where)
    if isinstance(algorithm.evaluator, TolerantEvaluator):
        algorithm.evaluator.count_on(counts)
    else:
        algorithm.evaluator.n_eval = counts["n_eval"]
    # a clock that was put back meanwhile must not make a run of less than no time
    algorithm.start_time = time.time() - max(0.0, entry(data, "elapsed_s", float))


def end_at(algorithm: ExtremalOptimization, termination: Any) -> None:
    """Give a run between two generations a new termination, in any form that pymoo takes."""
    algorithm.termination = _converted(termination)
    if algorithm.n_generations:
        algorithm.n_iter = algorithm.n_generations  # what a termination sees after a generation
        algorithm.termination.update(algorithm)
        algorithm.n_iter += 1


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
    """The algorithm, if it is the one of a saved run; or else the first difference is told."""
    cls, given = entry(data, "class", str), full_name(type(algorithm))
    if cls != given or not isinstance(algorithm, ExtremalOptimization):
        raise ValueError(f"class = {cls!r:.80}: the algorithm given is a {given}")
    parameters = _parameters(algorithm)
    for key, value in entry(data, "parameters", dict).items():
        # what is a constant now was a parameter in older versions
        found = parameters.get(key, _plain(key, getattr(type(algorithm), key, None)))
        if found != value:
            raise ValueError(f"parameters.{key} = {value!r:.80}: that given has {found!r:.80}")
    return algorithm


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
