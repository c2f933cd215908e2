"""Where walkers begin, if the user says so."""

import numpy as np
from numpy.typing import ArrayLike
from pymoo.core.population import Population
from pymoo.core.problem import Problem
from pymoo.core.sampling import Sampling

from mgeo._typing import FloatArray
from mgeo.algorithms.variables import Variables


def given_starts(
    sampling: Sampling | ArrayLike,
    problem: Problem,
    variables: Variables,
    n_walkers: int,
    random_state: np.random.Generator,
) -> FloatArray:
    """(n, n_var) values chosen by the user: points, a population, or a pymoo sampling.

    Raises
    ------
    TypeError : for anything else.
    ValueError : if there are not 1 to n_walkers points of n_var numbers each, within the bounds.
    """
    if isinstance(sampling, Sampling):
        sampling = sampling.do(problem, n_walkers, random_state=random_state)
    X = sampling.get("X") if isinstance(sampling, Population) else sampling
    try:
        starts = variables.values(np.asarray(X))
    except (TypeError, ValueError, KeyError) as error:
        raise TypeError(
            f"sampling = {sampling!r:.80}: expected None, a pymoo Sampling, a population, or an "
            "array of numbers of shape (n, n_var)"
        ) from error
    if starts.ndim != 2 or not len(starts) or starts.shape[1] != problem.n_var:
        raise ValueError(
            f"sampling of shape {starts.shape}: expected one row of n_var = {problem.n_var} "
            "numbers for each point to start at"
        )
    if len(starts) > n_walkers:
        raise ValueError(
            f"sampling of {len(starts)} points: expected at most one for each of the n_walkers = "
            f"{n_walkers} walkers (n_walkers={len(starts)} starts at all of them)"
        )
    outside = ~((starts >= variables.xl) & (starts <= variables.xu))
    if outside.any():
        walker, variable = np.argwhere(outside)[0]
        raise ValueError(
            f"sampling[{walker}, {variable}] = {starts[walker, variable]}: expected a number in "
            f"[{variables.xl[variable]}, {variables.xu[variable]}]"
        )
    return starts
