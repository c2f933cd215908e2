"""Problems, algorithms and whatever else an author may give, each by what it holds and runs."""

from __future__ import annotations

import copy
import warnings
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pymoo.core.algorithm import Algorithm
from pymoo.core.mixed import MixedVariableSampling
from pymoo.core.problem import Problem

from mgeo.plugins import protocol
from mgeo.studies.fingerprint.content import attributes, digest
from mgeo.studies.fingerprint.modules import UncertainError
from mgeo.studies.run import global_state


def fingerprint(*parts: Any) -> str:
    """32 hexadecimal digits that are the same, in any process, for what is made alike.

    A problem is evaluated at a few points, in a copy.

    Raises
    ------
    UncertainError
        If a part may compute something else the next time, for all that can be told.
    PluginError
        If an attribute ``fingerprint`` is no text.
    """
    return digest([_of(part) for part in parts], "fingerprint")


def _of(part: Any) -> Any:
    if not isinstance(part, Problem | Algorithm):
        return part
    kind, vouched = type(part), protocol.fingerprint(part)
    if vouched:
        return f"{kind.__module__}.{kind.__qualname__}", vouched, attributes(part, vouched=True)
    held = attributes(part)
    twin = _copy(part)
    for key, found in attributes(twin).items():
        if held.get(key) != found:
            raise UncertainError(f"{kind.__name__}.{key} is another one in a copy of it")
    if not isinstance(part, Problem):
        return digest(kind, kind.__name__), held
    points = probe_points(twin)
    with global_state(0), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        values = probed(twin, points)
        settled = attributes(twin)  # with the tables that it fills when it is first evaluated
        again = probed(twin, points)
    if again != values:
        raise UncertainError(f"{kind.__name__} gives other values when it is evaluated once more")
    # one that every evaluation changes, such as a counter, counts as it was
    counted = {key for key, found in attributes(twin).items() if settled.get(key) != found}
    held = settled | {key: held.get(key, "") for key in counted}
    names = list(getattr(part, "vars", None) or ())  # their order is that of the columns
    return digest(kind, kind.__name__), held, names, values


def _copy(part: Any) -> Any:
    try:
        return copy.deepcopy(part)
    except Exception as error:  # whatever foreign code raises
        raise UncertainError(f"{type(part).__name__} cannot be copied: {error}") from error


_VALUES = ["F", "G", "H"]
_POINTS = 4
_DIGITS = 10  # those beyond may be another processor's, or another NumPy's


def probe_points(problem: Problem) -> NDArray[Any]:
    """(4, n_var) points within the bounds, or (4,) of them that are dicts."""
    rng = np.random.default_rng(0)
    if getattr(problem, "vars", None) is not None:
        X: NDArray[Any] = MixedVariableSampling()(problem, _POINTS, random_state=rng).get("X")
        return X
    low = 0.0 if problem.xl is None else problem.xl
    high = 1.0 if problem.xu is None else problem.xu
    X = low + (high - low) * rng.random((_POINTS, problem.n_var))
    return np.rint(X).astype(problem.vtype) if problem.vtype in (int, bool) else X


def probed(problem: Problem, X: NDArray[Any]) -> list[Any]:
    """Objectives and constraints of all points, to ten digits; or of each, where one fails.

    Raises
    ------
    UncertainError
        If all end in an error: then nothing is known of what it computes.
    """
    whole = _values(problem, X)
    if not isinstance(whole, str):
        return [whole]
    found = [_values(problem, X[i : i + 1]) for i in range(len(X))]
    if all(isinstance(values, str) for values in found):
        raise UncertainError(f"{type(problem).__name__} failed at {len(X)} points, with {whole}")
    return found


def _values(problem: Problem, X: NDArray[Any]) -> dict[str, list[str]] | str:
    try:
        # a copy: some problems write into what they are given
        out = problem.evaluate(X.copy(), return_values_of=_VALUES, return_as_dictionary=True)
        values = {key: np.asarray(out[key], dtype=float).ravel() for key in _VALUES}
        return {key: [f"{each:.{_DIGITS - 1}e}" for each in found] for key, found in values.items()}
    except (Exception, SystemExit) as error:  # foreign code: it may raise anything
        return f"{type(error).__name__}: {error}"
