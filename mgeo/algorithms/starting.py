"""Where walkers start: at points that the user gives, or at designs that the problem suggests."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pymoo.core.population import Population
from pymoo.core.problem import Problem
from pymoo.core.sampling import Sampling
from pymoo.operators.sampling.rnd import FloatRandomSampling

from mgeo._typing import FloatArray
from mgeo.algorithms.variables import Variables, designs_of
from mgeo.validation.arguments import validate_integer


class SuggestedSampling(Sampling):
    """The first designs of a run are those that the problem suggests, all others are drawn.

    The problem has a method ``starts(n, random_state)`` that gives n designs as numbers, shape (n,
    n_var). Algorithms of mgeo, whose other walkers begin at random, evaluate them in their first
    generation, in addition to its candidates.

    Parameters
    ----------
    n : how many, from 1.
    others : pymoo `Sampling` of those beyond; default: uniform within the bounds.

    Raises
    ------
    ValueError : for n below 1; when designs are drawn, if the algorithm begins with fewer, or the
        problem suggests none, or none that it could take.

    Examples
    --------
    >>> import numpy as np
    >>> from mgeo import MGEODirected, SuggestedSampling
    >>> from mgeo_attitude import AttitudeManeuverProblem
    >>> algorithm = MGEODirected(sampling=SuggestedSampling(10))
    >>> AttitudeManeuverProblem().starts(2, np.random.default_rng(1)).shape
    (2, 12)
    """

    def __init__(self, n: int, others: Sampling | None = None) -> None:
        super().__init__()
        self.n = validate_integer("n", n, low=1)
        self.others = FloatRandomSampling() if others is None else others

    def suggested(
        self, problem: Problem, most: int, random_state: np.random.Generator
    ) -> FloatArray:
        """(n, n_var) numbers within the bounds; an algorithm begins with so many at most."""
        if self.n > most:
            raise ValueError(f"starts = {self.n}: expected at most {most}, with which it begins")
        suggest = getattr(problem, "starts", None)
        found = None if suggest is None else suggest(self.n, random_state)
        if found is None:
            name = type(problem).__name__
            raise ValueError(f"{name} has no starts(): expected a run without suggested designs")
        return np.asarray(found, dtype=float)

    def _do(
        self, problem: Problem, n_samples: int, *args: Any, random_state: Any = None, **kwargs: Any
    ) -> NDArray[Any]:
        first = designs_of(problem, self.suggested(problem, n_samples, random_state))
        if len(first) == n_samples:
            return first
        drawn = self.others.do(problem, n_samples - len(first), random_state=random_state)
        return np.concatenate([first, np.asarray(drawn.get("X"), dtype=first.dtype)])


def given_starts(
    sampling: Sampling | ArrayLike,
    problem: Problem,
    variables: Variables,
    n_walkers: int,
    random_state: np.random.Generator,
) -> FloatArray:
    """(n, n_var) values chosen by the user: points, a population, or a pymoo sampling.

    TypeError for anything else, ValueError if there are not 1 to n_walkers points of n_var numbers
    each, within the bounds.
    """
    if isinstance(sampling, SuggestedSampling):
        sampling = designs_of(problem, sampling.suggested(problem, n_walkers, random_state))
    elif isinstance(sampling, Sampling):
        sampling = sampling.do(problem, n_walkers, random_state=random_state)
    X = sampling.get("X") if isinstance(sampling, Population) else sampling
    try:
        starts = variables.values(np.asarray(X))
    except (TypeError, ValueError, KeyError) as error:
        raise TypeError(
            f"sampling = {sampling!r:.80}: expected None, a pymoo Sampling, a population, or an "
            "array of numbers of shape (n, n_var)"
        ) from error
    if np.shape(starts)[1:] != (problem.n_var,) or not 1 <= len(starts) <= n_walkers:
        raise ValueError(
            f"sampling of shape {starts.shape}: expected one row of n_var = {problem.n_var} "
            f"numbers for each point, and 1 to n_walkers = {n_walkers} of them"
        )
    outside = ~((starts >= variables.xl) & (starts <= variables.xu))
    for walker, variable in np.argwhere(outside):
        raise ValueError(
            f"sampling[{walker}, {variable}] = {starts[walker, variable]}: expected a number in "
            f"[{variables.xl[variable]}, {variables.xu[variable]}]"
        )
    return starts
