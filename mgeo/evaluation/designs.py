"""Design vectors of any kind as numbers."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from pymoo.core.problem import Problem


def variable_names(problem: Problem) -> tuple[str, ...] | None:
    """Names of the variables of a problem made by ``Problem(vars={...})``, else None."""
    declared = getattr(problem, "vars", None)
    return None if declared is None else tuple(declared)


def as_numbers(problem: Problem, X: NDArray[Any]) -> NDArray[Any]:
    """(n, n_var) design vectors as numbers, also where each of them is a dict.

    Raises
    ------
    ValueError : if a variable is not a number.
    """
    names = variable_names(problem)
    if names is not None and len(X) and isinstance(X[0], dict):
        X = np.array([[design[name] for name in names] for design in X], dtype=object)
    if X.dtype != object:
        return X.reshape(-1, problem.n_var)
    try:
        return X.astype(float).reshape(-1, problem.n_var)
    except (TypeError, ValueError) as error:
        raise ValueError(f"variables of {type(problem).__name__}: {error}") from error
