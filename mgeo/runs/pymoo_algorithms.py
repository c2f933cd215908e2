"""Adaptation of pymoo algorithms: operators for discrete variables, and reproducible runs."""

from __future__ import annotations

import copy
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from pymoo.algorithms.base.genetic import GeneticAlgorithm
from pymoo.algorithms.moo.cmopso import CMOPSO
from pymoo.algorithms.moo.nsga3 import comp_by_cv_then_random
from pymoo.algorithms.moo.rvea import RVEA
from pymoo.algorithms.moo.unsga3 import comp_by_rank_and_ref_line_dist
from pymoo.algorithms.soo.nonconvex.random_search import RandomSearch
from pymoo.core.initialization import Initialization
from pymoo.core.mating import Mating
from pymoo.core.mixed import (
    MixedVariableDuplicateElimination,
    MixedVariableMating,
    MixedVariableSampling,
)
from pymoo.operators.crossover.pntx import TwoPointCrossover
from pymoo.operators.mutation.bitflip import BitflipMutation
from pymoo.operators.repair.rounding import RoundingRepair
from pymoo.operators.sampling.rnd import BinaryRandomSampling, IntegerRandomSampling
from pymoo.operators.selection.tournament import TournamentSelection
from pymoo.termination.max_eval import MaximumFunctionCallTermination
from pymoo.util.optimum import filter_optimum

if TYPE_CHECKING:
    from pymoo.core.algorithm import Algorithm
    from pymoo.core.population import Population
    from pymoo.core.problem import Problem

# These comparisons break ties with random numbers from the operating system, without a seed.
_UNSEEDED_COMPARISONS = (comp_by_cv_then_random, comp_by_rank_and_ref_line_dist)
_SAMPLINGS = {
    "integer": IntegerRandomSampling,
    "binary": BinaryRandomSampling,
    "mixed": MixedVariableSampling,
}


def replace_operators(kind: str, algorithm: Algorithm, name: str) -> None:
    """Replace an algorithm's operators with those for integer, binary or mixed variables.

    Parameters
    ----------
    kind : str
        Kind of the variables: "integer", "binary", or "mixed" (declared one by one).
    algorithm : Algorithm
        New algorithm with operators for real variables.
    name : str
        Name of the algorithm, for messages.

    Raises
    ------
    ValueError
        If the operators of the algorithm cannot be replaced.
    """
    sampling: Any = _SAMPLINGS[kind]()
    mating: Any = getattr(algorithm, "mating", None)
    is_genetic = type(mating) is Mating and mating.crossover is not None
    takes_dicts = type(algorithm)._infill is GeneticAlgorithm._infill
    if isinstance(algorithm, RandomSearch):
        algorithm.sampling = sampling
    elif not is_genetic or (kind == "mixed" and not takes_dicts):
        raise ValueError(
            f"algorithm {name!r} takes arrays of real variables, and this problem has {kind} ones: "
            "expected an algorithm with suitable operators, such as mgeo-directed or nsga2"
        )
    elif kind == "mixed":
        elimination = MixedVariableDuplicateElimination()
        algorithm.eliminate_duplicates = elimination
        algorithm.mating = MixedVariableMating(eliminate_duplicates=elimination)
        algorithm.initialization = Initialization(sampling, eliminate_duplicates=elimination)
    else:
        algorithm.initialization.sampling = sampling
        if kind == "binary":
            mating.crossover, mating.mutation = TwoPointCrossover(), BitflipMutation()
        else:
            mating.crossover, mating.mutation = map(
                _add_rounding, (mating.crossover, mating.mutation)
            )


def _add_rounding(operator: Any) -> Any:
    rounded = copy.copy(operator)  # pymoo shares its default operators between algorithms.
    rounded.vtype, rounded.repair = float, RoundingRepair()
    return rounded


class SeededComparison:
    """Tournament comparison that breaks ties with the algorithm's random generator.

    Parameters
    ----------
    comparison : function
        Comparison function of pymoo's `TournamentSelection`.
    """

    def __init__(self, comparison: Any) -> None:
        self.comparison = comparison

    def __call__(
        self, pop: Population, P: NDArray[np.int_], random_state: Any = None, **options: Any
    ) -> NDArray[np.int_]:
        """Return the population index of the winner of each pair.

        Parameters
        ----------
        pop : Population
            Population.
        P : array of int, shape (n, 2)
            Indices of each pair in the population.
        random_state : numpy.random.Generator
            Generator that breaks ties.

        Returns
        -------
        array of int, shape (n, 1)
        """
        violation = pop.get("CV")[P, 0]
        tied = (violation[:, 0] == violation[:, 1]) & (violation[:, 0] > 0.0)
        winners = np.empty((len(P), 1), dtype=np.int_)
        winners[~tied] = self.comparison(pop, P[~tied], random_state=random_state, **options)
        winners[tied, 0] = random_state.permuted(P[tied], axis=1)[:, 0]
        return winners


def use_seeded_generator(algorithm: Algorithm) -> None:
    """Make an algorithm draw all random numbers from its own seeded generator.

    pymoo breaks ties in NSGA-III and selects elites in CMOPSO with unseeded random numbers, which
    makes runs irreproducible.
    """
    selection: Any = getattr(getattr(algorithm, "mating", None), "selection", None)
    if isinstance(selection, TournamentSelection) and selection.func_comp in _UNSEEDED_COMPARISONS:
        selection.func_comp = SeededComparison(selection.func_comp)
    if isinstance(algorithm, CMOPSO):
        survival = algorithm.elites.truncation.survival
        algorithm.elites.truncation = lambda solutions, k: survival.do(
            algorithm.problem, solutions, n_survive=k, random_state=algorithm.random_state
        )


class FrontRVEA(RVEA):
    """Variant of pymoo's RVEA whose result is the nondominated part of the population.

    The algorithm also uses its whole budget of evaluations, whereas pymoo's RVEA counts the first
    generation twice and ends one generation early.
    """

    termination: Any

    def _setup(self, problem: Problem, **options: Any) -> None:
        if isinstance(self.termination, MaximumFunctionCallTermination):
            budget = self.termination.n_max_evals + self.n_offsprings
            self.termination = MaximumFunctionCallTermination(budget)
        super()._setup(problem, **options)

    def _set_optimum(self, **options: Any) -> None:
        self.opt = filter_optimum(self.pop, least_infeasible=True)
