"""What any pymoo algorithm must do to be used in studies."""

import copy
import pickle
from typing import Any

import numpy as np
from pymoo.core.algorithm import Algorithm
from pymoo.core.result import Result
from pymoo.optimize import minimize

from mgeo.dominance import nondominated
from mgeo.testing.failure import no_error, require, require_equal
from mgeo.testing.samples import Bowls


def check_algorithm(
    algorithm: Algorithm,
    seed: int = 1,
    n_gen: int = 5,
    n_var: int = 4,
    n_obj: tuple[int, ...] = (1, 2, 3),
    constraints: bool = True,
) -> None:
    """Check an algorithm by short runs on small problems.

    Parameters
    ----------
    algorithm : an instance that has not been set up; it is left as it is.
    seed : of the runs.
    n_gen : generations per run, at least 3.
    n_var : variables of the problems.
    n_obj : numbers of objectives it claims to treat.
    constraints : whether it claims to treat inequality constraints.

    Raises
    ------
    CheckError : for the first rule that is broken.
    """
    require(isinstance(algorithm, Algorithm), f"{algorithm!r} is not a pymoo Algorithm")
    require(algorithm.problem is None, "the algorithm has been set up: expected a fresh one")
    for count in n_obj:
        problem = Bowls(n_var, count)
        result = _run(algorithm, problem, seed, n_gen)
        _check_result(problem, result)
        _check_seeds(algorithm, problem, result, seed, n_gen)
        _check_ask_and_tell(algorithm, problem, result, seed, n_gen)
        _check_copy_midway(algorithm, problem, result, seed, n_gen)
        _check_pickle(algorithm, problem, result, seed, n_gen)
        if constraints:
            _check_constraints(algorithm, n_var, count, seed, n_gen)


def _run(algorithm: Algorithm, problem: Bowls, seed: int, n_gen: int, **options: Any) -> Result:
    problem.seen.clear()
    with no_error(f"minimize with {problem.n_obj} objectives"):
        result = minimize(problem, algorithm, ("n_gen", n_gen), seed=seed, **options)
    require(algorithm.problem is None, "minimize must leave the algorithm itself as it was")
    return result


def _require_same(found: Any, expected: Result, rule: str) -> None:
    """Compare points and objectives of two results (or of an algorithm's optimum and a result)."""
    opt = found.opt
    require((opt is None) == (expected.opt is None), f"{rule}: one run found no solution")
    if expected.opt is not None:
        for key in ("X", "F"):
            require_equal(opt.get(key), expected.opt.get(key), f"{rule}: {key}")


def _check_result(problem: Bowls, result: Result) -> None:
    where = f"{problem.n_obj} objectives"
    visited = np.concatenate(problem.seen)
    inside = (visited >= problem.xl) & (visited <= problem.xu)
    require(inside.all(), f"{where}: points out of bounds were evaluated: {visited[~inside][:3]}")
    count = result.algorithm.evaluator.n_eval
    require(count == len(visited), f"{where}: n_eval = {count} after {len(visited)} evaluations")
    require(result.X is not None, f"{where}: nothing was found")
    X, F = np.atleast_2d(result.X), np.atleast_2d(result.F)
    require_equal(F, problem.evaluate(X), f"{where}: res.F must be the objectives of res.X", 1e-12)
    distinct = np.unique(F, axis=0)
    dominated = distinct[~nondominated(distinct)]
    require(len(dominated) == 0, f"{where}: points of res.F dominate each other: {dominated[:3]}")
    if problem.n_obj == 1:
        require(result.X.shape == (problem.n_var,), f"{where}: res.X of shape {result.X.shape}")


def _check_seeds(
    algorithm: Algorithm, problem: Bowls, result: Result, seed: int, n_gen: int
) -> None:
    before = _global_state()
    _require_same(_run(algorithm, problem, seed, n_gen), result, "same seed, same result")
    first = np.concatenate(problem.seen)
    _run(algorithm, problem, seed + 1, n_gen)
    require(
        not np.array_equal(first, np.concatenate(problem.seen)), "another seed, the same points"
    )
    require(
        _global_state() == before, "numpy's global random state was used: draw from random_state"
    )


def _global_state() -> tuple[list[int], int]:
    # The legacy state is not used here, only watched.
    state = np.random.get_state(legacy=False)["state"]  # noqa: NPY002
    return state["key"].tolist(), state["pos"]


def _check_ask_and_tell(
    algorithm: Algorithm, problem: Bowls, result: Result, seed: int, n_gen: int
) -> None:
    with no_error("ask and tell"):
        asked = copy.deepcopy(algorithm).setup(problem, termination=("n_gen", n_gen), seed=seed)
        while asked.has_next():
            infills = asked.ask()
            asked.evaluator.eval(problem, infills)
            asked.tell(infills=infills)
    _require_same(asked, result, "ask and tell, as minimize")


def _check_copy_midway(
    algorithm: Algorithm, problem: Bowls, result: Result, seed: int, n_gen: int
) -> None:
    with no_error("deepcopy in the middle of a run"):
        run = copy.deepcopy(algorithm).setup(problem, termination=("n_gen", n_gen), seed=seed)
        run.next()
        run.next()
        duplicate = copy.deepcopy(run)
        _require_same(run.run(), result, "a run that was copied midway")
        _require_same(duplicate.run(), result, "the copy of a run made midway")


def _check_pickle(
    algorithm: Algorithm, problem: Bowls, result: Result, seed: int, n_gen: int
) -> None:
    with no_error("pickle the algorithm"):
        revived = pickle.loads(pickle.dumps(algorithm))
    _require_same(_run(revived, problem, seed, n_gen), result, "a pickled copy, as itself")


def _check_constraints(algorithm: Algorithm, n_var: int, n_obj: int, seed: int, n_gen: int) -> None:
    half = _run(algorithm, Bowls(n_var, n_obj, "half"), seed, n_gen)
    require(half.X is not None, "half of the points are feasible: none was found")
    require(np.all(np.atleast_2d(half.X)[:, 0] >= 0), f"infeasible points returned: {half.X}")
    impossible = Bowls(n_var, n_obj, "impossible")
    none = _run(algorithm, impossible, seed, n_gen)
    require(none.X is None, f"no point is feasible: expected res.X None, got {none.X}")
    least = _run(algorithm, impossible, seed, n_gen, return_least_infeasible=True)
    require(least.X is not None, "return_least_infeasible: expected a point")
