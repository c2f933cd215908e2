"""Where the walkers of a real-coded algorithm begin."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike
from pymoo.core.population import Population
from pymoo.core.problem import Problem
from pymoo.core.sampling import Sampling

from mgeo.dominance import FloatArray


def uniform_starts(problem: Problem, streams: Sequence[np.random.Generator]) -> FloatArray:
    """(n_runs, n_var) points uniform within the bounds, each from its own stream."""
    unit = np.stack([stream.random(problem.n_var) for stream in streams])
    xl, xu = problem.bounds()
    starts: FloatArray = np.clip(xl + (xu - xl) * unit, xl, xu)
    return starts


def given_starts(
    sampling: Sampling | ArrayLike, problem: Problem, n_runs: int, random_state: np.random.Generator
) -> FloatArray:
    """(n_runs, n_var) points chosen by the user: the points, a population, or a pymoo sampling.

    Raises
    ------
    ValueError : if there are not n_runs points of n_var numbers each, within the bounds.
    """
    if isinstance(sampling, Sampling):
        sampling = sampling.do(problem, n_runs, random_state=random_state)
    X = sampling.get("X") if isinstance(sampling, Population) else sampling
    starts: FloatArray = np.array(X, dtype=float)
    if starts.shape != (n_runs, problem.n_var):
        raise ValueError(
            f"sampling of shape {starts.shape}: expected (n_runs, n_var) = "
            f"{(n_runs, problem.n_var)}, one point per walker"
        )
    outside = ~((starts >= problem.xl) & (starts <= problem.xu))
    if outside.any():
        walker, variable = np.argwhere(outside)[0]
        raise ValueError(
            f"sampling[{walker}, {variable}] = {starts[walker, variable]}: expected a number in "
            f"[{problem.xl[variable]}, {problem.xu[variable]}]"
        )
    return starts
