"""Trial runs, which detect irreproducible algorithms and noisy problems before a comparison."""

from __future__ import annotations

import copy
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

import joblib
import numpy as np
from pymoo.core.population import Population
from pymoo.core.problem import Problem

from mgeo._typing import FloatArray
from mgeo.algorithms.variables import get_kind
from mgeo.evaluation.evaluator import TolerantEvaluator
from mgeo.studies.run import Task, iterate_generations, seed_global_generators

# With these values, 20 of 20 trials detect that PatternSearch, NicheGA, SRES and ISRES of
# pymoo 0.6.2 are not reproducible on a constrained problem. With 4 levels, 11 of 20 detect ISRES.
_MIN_GENERATIONS, _MIN_EVALUATIONS = 12, 100  # Minimum length of a short run.
_UNLIMITED_BUDGET = 10**9  # A small budget may cut the first generation short.
_N_LEVELS = 10  # Number of different values of an objective.
_MAX_GENERATION_RATIO = 1.1  # Tolerated ratio of the first generation to the budget.
# Differences below this share of the largest value are rounding errors.
_ROUNDING_TOLERANCE = 1e-9


@dataclass(frozen=True)
class TrialResult:
    """Result of two short runs of an algorithm with equal seeds.

    Attributes
    ----------
    is_reproducible : bool
        Whether both runs proposed the same candidates.
    noise : float
        Largest difference between two evaluations of the same points.
    first_generation_size : int
        Number of evaluations of the first generation.
    fractional_value : float or None
        A fractional value that the algorithm proposed for an integer or binary variable.
    """

    is_reproducible: bool
    noise: float
    first_generation_size: int
    fractional_value: float | None


def make_trial_runs(task: Task) -> TrialResult | None:
    """Make two short runs to detect an irreproducible algorithm or a noisy problem.

    A short run has at least twelve generations and 100 evaluations, or `n_eval` evaluations if that
    is less. Its objectives are random values with many ties: they take no time to evaluate, and the
    algorithm must break ties. The problem itself evaluates three points, before and after the
    second run.

    Returns
    -------
    TrialResult or None
        None if one of the runs fails.
    """
    problem = copy.deepcopy(task.problem)
    problem.callback = None
    try:
        sizes, candidates = _make_short_run(task, copy.deepcopy(problem))
        points = candidates[0][[0, len(candidates[0]) // 2, -1]]
        # Another seed makes noise from the global generators differ between both evaluations.
        with seed_global_generators(task.seed + 1):
            first = _evaluate_points(problem, points)
        repeated_candidates = _make_short_run(task, problem)[1]
        with seed_global_generators(task.seed):
            second = _evaluate_points(problem, points)
    except Exception:  # External algorithms and problems may raise any error.
        return None
    difference = np.abs(first - second)
    is_noise = difference > _ROUNDING_TOLERANCE * np.abs(first).max(axis=0)
    noise = float(difference.max(initial=0.0, where=is_noise))
    is_reproducible = joblib.hash(candidates) == joblib.hash(repeated_candidates)
    return TrialResult(
        is_reproducible, noise, sizes[0], _find_fractional_value(problem, candidates)
    )


def describe_limitations(trials: Mapping[str, TrialResult], title: str, n_eval: int) -> list[str]:
    """Return warnings about a comparison of algorithms, based on short trial runs.

    The warnings concern a noisy problem, an algorithm that is not reproducible, and a first
    generation larger than the budget.

    Parameters
    ----------
    trials : mapping of str to TrialResult
        Results of the trial runs by algorithm label.
    title : str
        Name of the problem.
    n_eval : int
        Budget of each run.
    """
    sentences = []
    noise = max((trial.noise for trial in trials.values()), default=0.0)
    if noise:
        sentences.append(
            f"{title} is noisy: two evaluations of the same point differ by up to {noise:.2g}. The "
            "best values of a run are partly chance: evaluate the final fronts again, or let the "
            "problem average over several evaluations."
        )
    irreproducible = [label for label, trial in trials.items() if not trial.is_reproducible]
    if irreproducible:
        sentences.append(
            f"{title}: two runs of {', '.join(irreproducible)} with the same seed differ. Their "
            "runs cannot be repeated, and none is reused. Use algorithms that draw all random "
            "numbers from their random_state."
        )
    for label, trial in trials.items():
        if trial.first_generation_size > _MAX_GENERATION_RATIO * n_eval:
            sentences.append(
                f"{title}: the first generation of {label} has {trial.first_generation_size:,} "
                f"evaluations, of which only the first {n_eval:,} count. Use a larger budget, or "
                "an algorithm with smaller generations."
            )
    return sentences


def reject_fractional_values(trials: Mapping[str, TrialResult], title: str) -> None:
    """Raise a ValueError if an algorithm proposes fractional values of discrete variables.

    pymoo's default operators are for real variables, so that one algorithm would solve a relaxed
    problem and the others would not.
    """
    for label, trial in trials.items():
        if trial.fractional_value is not None:
            raise ValueError(
                f"{title} has integer variables, but {label} evaluates "
                f"{trial.fractional_value:.4g}: expected an algorithm with operators for integers "
                "(sampling, crossover, mutation and repair), see pymoo's page on discrete variables"
            )


def _find_fractional_value(problem: Problem, batches: Iterable[Any]) -> float | None:
    if get_kind(problem.vtype) not in ("integer", "binary"):
        return None
    values = np.concatenate([np.asarray(X, float).ravel() for X in batches])
    fractions = values[values != np.rint(values)]
    return float(fractions[0]) if len(fractions) else None


def _make_short_run(task: Task, problem: Problem) -> tuple[list[int], list[Any]]:
    """Run an algorithm briefly on random objectives. Return generation sizes and candidates."""
    batches: list[Any] = []
    sizes: list[int] = []
    unlimited_task = replace(task, n_eval=_UNLIMITED_BUDGET)
    with seed_global_generators(task.seed), _randomize_values(problem):
        for _ in iterate_generations(
            unlimited_task, problem, lambda _, pop, __: batches.append(pop.get("X"))
        ):
            sizes.append(sum(map(len, batches)) - sum(sizes))
            is_enough = len(sizes) >= _MIN_GENERATIONS and sum(sizes) >= _MIN_EVALUATIONS
            if is_enough or sum(sizes) >= task.n_eval:
                break
    return sizes, batches


@contextmanager
def _randomize_values(problem: Problem) -> Iterator[None]:
    """Replace the objectives and constraints of a problem with reproducible random numbers.

    The context manager applies to all fidelity levels.
    """
    random_state, is_elementwise = np.random.default_rng(0), problem.elementwise

    def evaluate(X: Any, out: dict[str, Any], *args: Any, **kwargs: Any) -> None:
        ranges = {
            "F": (0, _N_LEVELS, problem.n_obj),
            "G": (-1, 2, problem.n_ieq_constr),
            "H": (0, 2, problem.n_eq_constr),
        }
        for name, (low, high, width) in ranges.items():
            out[name] = random_state.integers(low, high, (len(X), width)).astype(float)

    replacements = {"_evaluate": evaluate, "at_fidelity": lambda fidelity: problem}
    vars(problem).update(replacements, elementwise=False)
    try:
        yield
    finally:
        for name in replacements:
            del vars(problem)[name]
        problem.elementwise = is_elementwise


def _evaluate_points(problem: Problem, X: Any) -> FloatArray:
    """Evaluate points, and return their objectives and constraint values in one array."""
    population = Population.new("X", X)
    TolerantEvaluator(warn=False).eval(problem, population)
    return np.column_stack(population.get("F", "G", "H"))
