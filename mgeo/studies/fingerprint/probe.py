"""What a problem computes, at a few points that are always the same."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from pymoo.core.mixed import MixedVariableSampling

from mgeo.studies.fingerprint.modules import UncertainError

if TYPE_CHECKING:
    from pymoo.core.problem import Problem

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
