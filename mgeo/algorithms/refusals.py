"""What pymoo's algorithms take and this family cannot, each with the way to do it here."""

from __future__ import annotations

from typing import Any

from pymoo.core.problem import Problem
from pymoo.problems.dyn import DynamicProblem

_OPERATORS = "the algorithm's own parameters say how candidates are made and chosen"

# Options of pymoo's algorithms, in their constructors and in runs, that examples use.
_WALKERS = "n_walkers is the number of walkers, each of which proposes candidates of its own"
INSTEAD = {
    "pop_size": _WALKERS,
    "n_offsprings": _WALKERS,
    "n_runs": _WALKERS,
    "ref_dirs": "MGEODirected(n_walkers=...) spreads its walkers over the objectives by itself",
    "x0": "sampling=[x0] lets the first walker begin there",
    "repair": "repair the design within the problem, or let a constraint measure what is wrong",
    "eliminate_duplicates": "of equal objective vectors the front keeps one in any case",
    "crossover": _OPERATORS,
    "mutation": _OPERATORS,
    "selection": _OPERATORS,
    "survival": _OPERATORS,
    "disp": "verbose=True prints a line a generation",
    "n_gen": "termination=('n_gen', ...) says how long to run",
    "n_eval": "termination=('n_eval', ...) says how long to run",
}


def refuse_dynamic(problem: Problem, name: str) -> None:
    """Refuse a problem whose values change during a run.

    Raises
    ------
    ValueError : for pymoo's dynamic problems, and others whose clock its `TimeSimulation` moves.
    """
    if isinstance(problem, DynamicProblem) or callable(getattr(problem, "tic", None)):
        raise ValueError(
            f"{type(problem).__name__} is a dynamic problem, and the front of {name} would keep "
            "objectives of times that are past: expected a problem whose values do not change "
            "during a run (pymoo's DNSGA2 and KGB treat others)"
        )


def refuse_used(algorithm: Any) -> None:
    """Refuse to set up an algorithm that has begun a run, which would go on from its end.

    Raises
    ------
    RuntimeError : if it has.
    """
    if algorithm.n_iter is not None:
        raise RuntimeError(
            f"this {type(algorithm).__name__} has begun a run: expected a new one to set up, or a "
            "copy.deepcopy of one before its run"
        )
