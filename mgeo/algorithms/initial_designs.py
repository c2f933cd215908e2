"""Initial designs of a run, and the size of its first generation."""

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
from mgeo.algorithms.variables import Variables, convert_numbers_to_designs
from mgeo.evaluation.individuals import find_successful
from mgeo.validation.arguments import validate_integer

#: Fraction by which the first generation may exceed the evaluation budget.
_MAX_BUDGET_EXCESS = 0.1


class SuggestedSampling(Sampling):
    """Sampling operator that starts with designs suggested by the problem.

    The problem must define a method ``suggest_initial_designs(n, random_state)`` that returns n
    designs as an array of shape (n, n_var). Walkers of the MGEO family beyond the first n start at
    random.

    Parameters
    ----------
    n : int
        Number of suggested designs, at least 1.
    fallback : Sampling, optional
        pymoo `Sampling` for the remaining designs; uniform within the bounds by default.

    Raises
    ------
    ValueError
        If `n` is less than 1. During sampling, if `n` exceeds the number of initial designs of the
        algorithm, or the problem suggests no designs.

    Examples
    --------
    >>> import numpy as np
    >>> from mgeo import MGEODirected, SuggestedSampling
    >>> from mgeo_attitude import AttitudeManeuverProblem
    >>> algorithm = MGEODirected(sampling=SuggestedSampling(10))
    >>> AttitudeManeuverProblem().suggest_initial_designs(2, np.random.default_rng(1)).shape
    (2, 12)
    """

    def __init__(self, n: int, fallback: Sampling | None = None) -> None:
        super().__init__()
        self.n = validate_integer("n", n, low=1)
        self.fallback = FloatRandomSampling() if fallback is None else fallback

    def get_suggested_designs(
        self, problem: Problem, n_max: int, random_state: np.random.Generator
    ) -> FloatArray:
        """Return the initial designs suggested by the problem, with one row per design.

        The attribute `n` is the number of designs.

        Parameters
        ----------
        problem : Problem
        n_max : int
            Number of initial designs of the algorithm.
        random_state : numpy.random.Generator

        Raises
        ------
        ValueError
            If `n` exceeds `n_max`, or the problem suggests no designs.
        """
        if self.n > n_max:
            raise ValueError(
                f"initial_designs = {self.n}: expected at most {n_max}, the number of initial "
                "designs of the algorithm"
            )
        suggest = getattr(problem, "suggest_initial_designs", None)
        designs = None if suggest is None else suggest(self.n, random_state)
        if designs is None:
            name = type(problem).__name__
            raise ValueError(
                f"{name} has no suggest_initial_designs(): expected a run without suggested designs"
            )
        return np.asarray(designs, dtype=float)

    def _do(
        self, problem: Problem, n_samples: int, *args: Any, random_state: Any = None, **kwargs: Any
    ) -> NDArray[Any]:
        designs = convert_numbers_to_designs(
            problem, self.get_suggested_designs(problem, n_samples, random_state)
        )
        if len(designs) == n_samples:
            return designs
        rest = self.fallback.do(problem, n_samples - len(designs), random_state=random_state)
        return np.concatenate([designs, np.asarray(rest.get("X"), dtype=designs.dtype)])


def find_evaluated(population: Population, problem: Problem) -> BoolArray:
    """Find the individuals of a population that have already been evaluated successfully.

    Parameters
    ----------
    population : Population
        n individuals.
    problem : Problem
        Problem of the run, whose numbers of values the individuals must have.

    Returns
    -------
    array of bool, shape (n,)
        True where F, G and H are evaluated and the evaluation did not fail.

    Raises
    ------
    ValueError
        If the shapes of evaluated values do not match the problem.
    """
    widths = {"F": problem.n_obj, "G": problem.n_ieq_constr, "H": problem.n_eq_constr}
    mask = np.array([widths.keys() <= each.evaluated for each in population]) & find_successful(
        population
    )
    for row in np.flatnonzero(mask):
        for name, width in widths.items():
            if np.shape(values := getattr(population[row], name)) != (width,):
                raise ValueError(
                    f"sampling[{row}].{name} of shape {np.shape(values)}: expected ({width},), for "
                    f"individuals evaluated by {type(problem).__name__}"
                )
    return mask


def build_initial_designs(
    sampling: Sampling | ArrayLike | None,
    problem: Problem,
    variables: Variables,
    n_walkers: int,
    random_state: np.random.Generator,
) -> FloatArray:
    """Return the initial designs defined by the parameter `sampling`, with one row per design.

    Parameters
    ----------
    sampling : Sampling, Population or array_like, shape (n, n_var), or None
        Initial designs; None for none.
    problem : Problem
    variables : Variables
        Variables of the problem.
    n_walkers : int
        Largest number of initial designs.
    random_state : numpy.random.Generator
        Random stream for a `Sampling`.

    Returns
    -------
    array, shape (n, n_var)
        Initial designs; n = 0 for None.

    Raises
    ------
    TypeError
        If `sampling` has another type, or contains values that are not numbers.
    ValueError
        If there are not 1 to `n_walkers` points, or a point is out of bounds.
    """
    if sampling is None:
        return np.empty((0, problem.n_var))
    if isinstance(sampling, SuggestedSampling):
        sampling = convert_numbers_to_designs(
            problem, sampling.get_suggested_designs(problem, n_walkers, random_state)
        )
    elif isinstance(sampling, Sampling):
        sampling = sampling.do(problem, n_walkers, random_state=random_state)
    X = sampling.get("X") if isinstance(sampling, Population) else sampling
    try:
        initial_designs = variables.to_numbers(np.asarray(X))
    except (TypeError, ValueError, KeyError) as error:
        raise TypeError(
            f"sampling = {sampling!r:.80}: expected None, a pymoo Sampling, a population, or an "
            "array of numbers of shape (n, n_var)"
        ) from error
    if (
        np.shape(initial_designs)[1:] != (problem.n_var,)
        or not 1 <= len(initial_designs) <= n_walkers
    ):
        raise ValueError(
            f"sampling of shape {initial_designs.shape}: expected one row of n_var = "
            f"{problem.n_var} numbers for each point, and 1 to n_walkers = {n_walkers} points"
        )
    is_outside = ~((initial_designs >= variables.xl) & (initial_designs <= variables.xu))
    for walker, variable in np.argwhere(is_outside):
        raise ValueError(
            f"sampling[{walker}, {variable}] = {initial_designs[walker, variable]}: expected a "
            f"number in [{variables.xl[variable]}, {variables.xu[variable]}]"
        )
    return initial_designs


def count_allowed_evaluations(algorithm: Algorithm, n_initial_designs: int, n_points: int) -> int:
    """Return how many points of the first generation can be evaluated within the budget.

    Parameters
    ----------
    algorithm : Algorithm
        Algorithm after `setup`.
    n_initial_designs : int
        Number of initial designs, which are always evaluated.
    n_points : int
        Number of initial designs and candidates.

    Returns
    -------
    int
        `n_points`, or fewer if the budget would be exceeded by more than 10 %.

    Warns
    -----
    RuntimeWarning
        If the first generation is truncated.
    """
    termination = algorithm.termination
    # A combination that ends when all criteria are met has no evaluation budget.
    is_any = not isinstance(termination, TerminateIfAll)
    criteria = (termination, *(getattr(termination, "criteria", ()) if is_any else ()))
    budgets = [
        criterion.n_max_evals
        for criterion in criteria
        if isinstance(criterion, MaximumFunctionCallTermination)
        and criterion.n_max_evals is not None
    ]
    budget = min(budgets, default=math.inf) - algorithm.evaluator.n_eval
    if n_points <= (1.0 + _MAX_BUDGET_EXCESS) * budget:
        return n_points
    allowed = max(int(budget), n_initial_designs)
    warnings.warn(
        f"the first generation of {type(algorithm).__name__} takes {n_points:,} evaluations, which "
        f"exceeds the budget of {budget:,}: only the first {allowed:,} points are evaluated. "
        "Reduce the number of candidates, for instance by n_walkers, or increase the budget",
        RuntimeWarning,
        stacklevel=2,
    )
    return allowed
