"""Algorithms set up for a problem: operators for its variables, and everything drawn by the seed.

Algorithms of pymoo search real numbers by default, also where a problem declares other variables by
its ``vtype`` or its ``vars``.
"""

from __future__ import annotations

import copy
from typing import TYPE_CHECKING, Any, TypeVar

from pymoo.algorithms.base.genetic import GeneticAlgorithm
from pymoo.algorithms.moo.nsga3 import comp_by_cv_then_random
from pymoo.algorithms.moo.unsga3 import comp_by_rank_and_ref_line_dist
from pymoo.algorithms.soo.nonconvex.random_search import RandomSearch
from pymoo.core.duplicate import DefaultDuplicateElimination, NoDuplicateElimination
from pymoo.core.initialization import Initialization
from pymoo.core.mating import Mating
from pymoo.core.mixed import (
    MixedVariableDuplicateElimination,
    MixedVariableMating,
    MixedVariableSampling,
)
from pymoo.core.repair import NoRepair
from pymoo.core.sampling import Sampling
from pymoo.operators.crossover.pcx import PCX
from pymoo.operators.crossover.pntx import TwoPointCrossover
from pymoo.operators.crossover.sbx import SBX
from pymoo.operators.mutation.bitflip import BitflipMutation
from pymoo.operators.mutation.gauss import GM, GaussianMutation
from pymoo.operators.mutation.pm import PM, PolynomialMutation
from pymoo.operators.repair.rounding import RoundingRepair
from pymoo.operators.repair.to_bound import ToBoundOutOfBoundsRepair
from pymoo.operators.sampling.lhs import LHS, LatinHypercubeSampling
from pymoo.operators.sampling.rnd import (
    BinaryRandomSampling,
    FloatRandomSampling,
    IntegerRandomSampling,
)
from pymoo.operators.selection.tournament import TournamentSelection

from mgeo.algorithms.base import ExtremalOptimization
from mgeo.algorithms.starting import SuggestedSampling
from mgeo.algorithms.variables import KINDS, Variables, kind_of_type
from mgeo.evaluation.evaluator import TolerantEvaluator
from mgeo.runs.pymoo_algorithms import SeededComparison, seed_archives

if TYPE_CHECKING:
    from pymoo.core.algorithm import Algorithm
    from pymoo.core.problem import Problem

T = TypeVar("T")

#: Steps without an evaluation, after which an algorithm has no new candidate.
IDLE_STEPS = 100

# Exactly these make real numbers: what is made from them may be something else.
_REAL_SAMPLING = (FloatRandomSampling, LatinHypercubeSampling, LHS)
_REAL_OPERATORS = (SBX, PCX, PM, PolynomialMutation, GM, GaussianMutation)
_NO_REPAIR = (type(None), NoRepair, ToBoundOutOfBoundsRepair)  # of what a variable is
# Comparisons of pymoo whose ties of violation are drawn from the entropy of the operating system.
_UNSEEDED = (comp_by_cv_then_random, comp_by_rank_and_ref_line_dist)


def set_up(
    problem: Problem, algorithm: Algorithm, evaluations: int, seed: int, starts: int = 0
) -> Algorithm:
    """Return a copy of an algorithm, set up for its first step. Nothing is evaluated yet.

    Parameters
    ----------
    starts
        Number of initial designs that the problem suggests.

    Raises
    ------
    ValueError
        If `evaluations` or `seed` is out of range, or the algorithm refuses the problem, or the
        designs.
    """
    if evaluations < 1:
        raise ValueError(f"evaluations = {evaluations}: expected >= 1")
    if seed < 0:
        raise ValueError(f"seed = {seed}: expected >= 0")
    ready = fitted(algorithm, problem)
    ready = copy.deepcopy(with_suggested(ready, starts) if starts else ready)
    ready.evaluator = TolerantEvaluator.like(ready.evaluator)
    ready.evaluator.warn = False  # the outcome has the failures
    ready.setup(problem, termination=("n_eval", evaluations), seed=seed)
    seed_archives(ready)
    return ready


def fitted(algorithm: Algorithm, problem: Problem, name: str = "") -> Algorithm:
    """The algorithm itself, or one that searches the problem's variables as what they are.

    Where the problem's variables are integers, bits, or declared one by one, a genetic algorithm
    or random search of pymoo gets the operators for them that pymoo's documentation gives it, in
    place of those for real numbers; others that it was made with stay. Integers keep the
    parameters of crossover and mutation. Comparisons that do not repeat are replaced in any case.
    What is not pymoo's is left alone.

    Parameters
    ----------
    algorithm : one that has not begun; it is not changed.
    name : what to call it in errors; default: its class.

    Raises
    ------
    ValueError : if it is one of pymoo's without operators for such variables.
    """
    if isinstance(algorithm, ExtremalOptimization):
        return algorithm
    declared = getattr(problem, "vars", None) is not None
    kind = "mixed" if declared else kind_of_type(problem.vtype)
    if kind not in (None, "real"):
        algorithm = _with_operators(algorithm, problem, kind, name)
    return _seeded(algorithm)


def with_suggested(algorithm: Algorithm, n: int) -> Algorithm:
    """The algorithm, beginning with n designs that the problem suggests.

    Raises
    ------
    ValueError : if it takes none, or fewer.
    """
    name = type(algorithm).__name__
    most = getattr(algorithm, "n_walkers", None) or getattr(algorithm, "pop_size", None)
    if most is not None and n > most:
        raise ValueError(f"starts = {n}: expected at most {most}, with which {name} begins")
    if isinstance(algorithm, ExtremalOptimization):
        return _with(algorithm, sampling=SuggestedSampling(n))
    begin: Any = getattr(algorithm, "initialization", None)
    if not isinstance(getattr(begin, "sampling", None), Sampling):
        raise ValueError(f"starts = {n}: {name} takes no designs to begin with: expected 0")
    return _with(
        algorithm, initialization=_with(begin, sampling=SuggestedSampling(n, begin.sampling))
    )


def _with_operators(algorithm: Algorithm, problem: Problem, kind: str, name: str) -> Algorithm:
    if isinstance(algorithm, RandomSearch):
        return _with(algorithm, sampling=_sampling(algorithm.sampling, problem, kind))
    mating: Any = getattr(algorithm, "mating", None)
    crosses = type(mating) is Mating and mating.crossover is not None
    if crosses and kind != "mixed":
        changed = _whole(mating, kind)
        from pymoo.algorithms.moo.ctaea import CTAEA  # takes long to import

        begin = algorithm.initialization
        begin = _with(begin, sampling=_sampling(begin.sampling, problem, kind))
        none = isinstance(begin.eliminate_duplicates, NoDuplicateElimination)
        if isinstance(algorithm, CTAEA) and not none:
            # it goes round for ever if it begins with fewer than there are directions
            begin = _with(begin, eliminate_duplicates=NoDuplicateElimination())
        return _with(algorithm, mating=changed, initialization=begin)
    if crosses and type(algorithm)._infill is GeneticAlgorithm._infill:
        return _mixed(algorithm)
    if _takes_reals_alone(algorithm, mating):
        told = {"mixed": "declares its variables one by one", "binary": "has binary variables"}
        raise ValueError(
            f"{name or type(algorithm).__name__} takes arrays of real variables, and this problem "
            f"{told.get(kind, 'has integer variables')}: expected an algorithm with operators for "
            "them, such as MGEODirected (mgeo-directed) or NSGA2 (nsga2)"
        )
    return algorithm


def _whole(mating: Any, kind: str) -> Any:
    """A mating of arrays for integers or bits."""
    crossover, mutation = mating.crossover, mating.mutation
    if kind == "binary":
        if type(crossover) in _REAL_OPERATORS:
            crossover = TwoPointCrossover()
        if type(mutation) in _REAL_OPERATORS:
            mutation = BitflipMutation()
    elif not isinstance(mating.repair, RoundingRepair):
        crossover, mutation = _rounded(crossover), _rounded(mutation)
    return _with(mating, crossover=crossover, mutation=mutation)


def _rounded(operator: Any) -> Any:
    if type(operator) not in _REAL_OPERATORS or operator.repair is not None:
        return operator
    return _with(operator, vtype=float, repair=RoundingRepair())


def _mixed(algorithm: Any) -> Any:
    """A genetic algorithm for ``Problem(vars=...)``, of which each design is a dict."""
    same = algorithm.eliminate_duplicates
    if type(same) is DefaultDuplicateElimination:  # of arrays
        same = MixedVariableDuplicateElimination()
    begin = algorithm.initialization
    if type(begin.sampling) in _REAL_SAMPLING:
        begin = Initialization(MixedVariableSampling(), algorithm.repair, same)
    return _with(
        algorithm,
        mating=MixedVariableMating(repair=algorithm.repair, eliminate_duplicates=same),
        eliminate_duplicates=same,
        initialization=begin,
    )


def _sampling(sampling: Any, problem: Problem, kind: str) -> Any:
    if type(sampling) not in _REAL_SAMPLING:
        return sampling
    Variables.of(problem, KINDS)  # a bound that is missing or broken is refused here
    if kind == "mixed":
        return MixedVariableSampling()
    return BinaryRandomSampling() if kind == "binary" else IntegerRandomSampling()


def _takes_reals_alone(algorithm: Algorithm, mating: Any) -> bool:
    """Return whether a pymoo algorithm has no operator that makes other designs than reals."""
    makers = (cls for cls in type(algorithm).__mro__ if vars(cls).keys() & {"_infill", "_next"})
    maker = algorithm if mating is None else mating
    return (
        next(makers, object).__module__.startswith("pymoo.algorithms.")
        and (mating is None or type(mating).__module__.startswith("pymoo."))
        and not isinstance(mating, MixedVariableMating)
        and type(getattr(maker, "repair", None)) in _NO_REPAIR
    )


def _seeded(algorithm: Any) -> Any:
    mating = getattr(algorithm, "mating", None)
    selection = getattr(mating, "selection", None)
    if not isinstance(selection, TournamentSelection) or selection.func_comp not in _UNSEEDED:
        return algorithm
    selection = _with(selection, func_comp=SeededComparison(selection.func_comp))
    return _with(algorithm, mating=_with(mating, selection=selection))


def _with(part: T, **values: Any) -> T:
    """The part itself if it has these values, else a copy that has them."""
    if all(getattr(part, key) is value for key, value in values.items()):
        return part
    changed = copy.copy(part)
    vars(changed).update(values)
    return changed
