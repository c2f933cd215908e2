"""Starting points of a run, and what its first generation evaluates."""

from __future__ import annotations

import math
import warnings
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pymoo.core.algorithm import Algorithm
from pymoo.core.population import Population
from pymoo.core.problem import Problem
from pymoo.core.sampling import Sampling
from pymoo.core.termination import TerminateIfAll
from pymoo.operators.sampling.rnd import FloatRandomSampling
from pymoo.termination.max_eval import MaximumFunctionCallTermination

from mgeo._typing import BoolArray, FloatArray
from mgeo.algorithms.variables import Variables, designs_of
from mgeo.evaluation.individuals import succeeded
from mgeo.validation.arguments import validate_integer

_EXCESS = 0.1  # share of the budget by which the first generation may exceed it


class SuggestedSampling(Sampling):
    """The first designs of a run are those that the problem suggests, all others are drawn.

    The problem has a method ``starts(n, random_state)`` that gives n designs as numbers, shape (n,
    n_var). Walkers of the MGEO family beyond the first n start at random.

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


def are_evaluated(given: Population, problem: Problem) -> BoolArray:
    """Return which individuals have the values of a problem, (n,).

    Raises
    ------
    ValueError : if values have other shapes than the problem's.
    """
    widths = {"F": problem.n_obj, "G": problem.n_ieq_constr, "H": problem.n_eq_constr}
    mask = np.array([widths.keys() <= each.evaluated for each in given]) & succeeded(given)
    for row in np.flatnonzero(mask):
        for name, width in widths.items():
            if np.shape(values := getattr(given[row], name)) != (width,):
                raise ValueError(
                    f"sampling[{row}].{name} of shape {np.shape(values)}: expected ({width},), "
                    f"individuals evaluated by {type(problem).__name__}"
                )
    return mask


def given_starts(
    sampling: Sampling | ArrayLike | None,
    problem: Problem,
    variables: Variables,
    n_walkers: int,
    random_state: np.random.Generator,
) -> FloatArray:
    """(n, n_var) values chosen by the user: points, a population, or a pymoo sampling; 0 for None.

    TypeError for anything else, ValueError if there are not 1 to n_walkers points of n_var numbers
    each, within the bounds.
    """
    if sampling is None:
        return np.empty((0, problem.n_var))
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


def evaluations_allowed(algorithm: Algorithm, n_starts: int, n: int) -> int:
    """Return how many points of the first generation fit into the budget of evaluations.

    Parameters
    ----------
    algorithm : the algorithm, set up.
    n_starts : number of starting points, which are evaluated in any case.
    n : number of starting points and candidates.

    Warns
    -----
    RuntimeWarning : if the generation exceeds the budget by more than a tenth and is therefore cut.
    """
    termination = algorithm.termination
    is_any = not isinstance(termination, TerminateIfAll)
    parts = (termination, *(getattr(termination, "criteria", ()) if is_any else ()))
    limits = [
        part.n_max_evals
        for part in parts
        if isinstance(part, MaximumFunctionCallTermination) and part.n_max_evals is not None
    ]
    budget = min(limits, default=math.inf) - algorithm.evaluator.n_eval
    if n <= (1.0 + _EXCESS) * budget:
        return n
    allowed = max(int(budget), n_starts)
    warnings.warn(
        f"the first generation of {type(algorithm).__name__} takes {n:,} evaluations, which exceeds"
        f" the budget of {budget:,}: only the first {allowed:,} points are evaluated. Reduce the "
        "number of candidates, for instance by n_walkers, or increase the budget",
        RuntimeWarning,
        stacklevel=2,
    )
    return allowed
