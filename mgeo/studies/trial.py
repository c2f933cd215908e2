"""Trial of an algorithm before its runs: whether they repeat, and whether the problem is noisy."""

from __future__ import annotations

import copy
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

import joblib
import numpy as np
from pymoo.core.population import Population
from pymoo.core.problem import Problem

from mgeo._typing import FloatArray
from mgeo.evaluation.evaluator import TolerantEvaluator
from mgeo.studies.run import Task, generations, global_state

# With these, 20 of 20 trials find that PatternSearch, NicheGA, SRES and ISRES of pymoo 0.6.2 do not
# follow the seed on a problem with a constraint; with 4 levels it is 11 of 20 for ISRES.
_GENERATIONS, _EVALUATIONS = 12, 100  # of a short run, at least
_UNLIMITED = 10**9  # budget of a short run: a small one may cut the first generation
_LEVELS = 10  # different values of an objective
_EXCESS = 1.1  # times the budget
_ROUNDING = 1e-9  # of the largest value, which is no noise


@dataclass(frozen=True)
class Trial:
    """Result of two short runs of one algorithm with one seed.

    Attributes
    ----------
    repeats : whether both proposed the same candidates.
    noise : largest difference of a value between two evaluations of the same points.
    first_generation : number of evaluations of the first generation.
    """

    repeats: bool
    noise: float
    first_generation: int


def try_out(task: Task) -> Trial | None:
    """Make two short runs of a task; return None if one fails, as the run itself may.

    A short run is twelve generations with 100 evaluations or more, or `n_eval` evaluations if these
    are fewer. Random values with many ties take the place of the problem's: they cost nothing, and
    they make an algorithm break ties. The problem itself evaluates three points before the second
    run and again after it.
    """
    problem = copy.deepcopy(task.problem)
    problem.callback = None
    try:
        sizes, candidates = _short_run(task, copy.deepcopy(problem))
        points = candidates[0][[0, len(candidates[0]) // 2, -1]]
        with global_state(task.seed + 1):  # other noise than afterwards
            first = _values(problem, points)
        again = _short_run(task, problem)[1]
        with global_state(task.seed):
            second = _values(problem, points)
    except Exception:  # algorithms and problems of others may raise anything
        return None
    change = np.abs(first - second)
    differs = change > _ROUNDING * np.abs(first).max(axis=0)
    noise = float(change.max(initial=0.0, where=differs))
    return Trial(joblib.hash(candidates) == joblib.hash(again), noise, sizes[0])


def notes(trials: Mapping[str, Trial], title: str, n_eval: int) -> list[str]:
    """Return a sentence on each reason to read a comparison with care.

    Parameters
    ----------
    trials : by the label of the algorithm.
    title : name of the problem.
    n_eval : budget of each run.
    """
    found = []
    noise = max((trial.noise for trial in trials.values()), default=0.0)
    if noise:
        found.append(
            f"{title} is noisy: two evaluations of the same point differ by up to {noise:.2g}. The "
            "best values of a run are partly luck: evaluate final fronts again, or let the problem "
            "average over several evaluations."
        )
    unseeded = [label for label, trial in trials.items() if not trial.repeats]
    if unseeded:
        found.append(
            f"{title}: two runs of {', '.join(unseeded)} with the same seed differ. Their runs "
            "cannot be repeated, and none is reused: expected algorithms that draw all random "
            "numbers from their random_state."
        )
    for label, trial in trials.items():
        if trial.first_generation > _EXCESS * n_eval:
            found.append(
                f"{title}: the first generation of {label} has {trial.first_generation:,} "
                f"evaluations, of which the first {n_eval:,} count: expected a larger budget, or "
                "an algorithm of smaller generations."
            )
    return found


def _short_run(task: Task, problem: Problem) -> tuple[list[int], list[Any]]:
    """Return the number of evaluations of each generation, and the X of each batch."""
    batches: list[Any] = []
    sizes: list[int] = []
    whole = replace(task, n_eval=_UNLIMITED)
    with global_state(task.seed), _random_values(problem):
        for _ in generations(whole, problem, lambda _, pop, __: batches.append(pop.get("X"))):
            sizes.append(sum(map(len, batches)) - sum(sizes))
            is_enough = len(sizes) >= _GENERATIONS and sum(sizes) >= _EVALUATIONS
            if is_enough or sum(sizes) >= task.n_eval:
                break
    return sizes, batches


@contextmanager
def _random_values(problem: Problem) -> Iterator[None]:
    """Let a problem give random values with many ties, the same ones in the same order.

    So does the problem at each stage of `MGEOStaged`.
    """
    random_state, is_elementwise = np.random.default_rng(0), problem.elementwise

    def evaluate(X: Any, out: dict[str, Any], *args: Any, **kwargs: Any) -> None:
        ends = {
            "F": (0, _LEVELS, problem.n_obj),
            "G": (-1, 2, problem.n_ieq_constr),
            "H": (0, 2, problem.n_eq_constr),
        }
        for name, (low, high, width) in ends.items():
            out[name] = random_state.integers(low, high, (len(X), width)).astype(float)

    replaced = {"_evaluate": evaluate, "at_stage": lambda stage: problem}
    vars(problem).update(replaced, elementwise=False)
    try:
        yield
    finally:
        for name in replaced:
            del vars(problem)[name]
        problem.elementwise = is_elementwise


def _values(problem: Problem, X: Any) -> FloatArray:
    """Return F, G and H of some points side by side."""
    population = Population.new("X", X)
    TolerantEvaluator(warn=False).eval(problem, population)
    return np.column_stack(population.get("F", "G", "H"))
