"""What any pymoo algorithm must do to be used in studies, on small problems."""

from __future__ import annotations

import copy
import pickle
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from pymoo.core.algorithm import Algorithm
from pymoo.core.problem import Problem
from pymoo.core.result import Result
from pymoo.optimize import minimize

from mgeo._typing import FloatArray
from mgeo.algorithms.base import ExtremalOptimization
from mgeo.algorithms.state import capture, restore
from mgeo.evaluation.dominance import nondominated
from mgeo.testing.check import no_error, require, require_equal

Constraint = Literal["none", "half", "impossible"]


def check_algorithm(
    algorithm: Algorithm | type[Algorithm],
    seed: int = 1,
    n_gen: int = 5,
    n_var: int = 4,
    n_obj: tuple[int, ...] = (1, 2, 3),
    constraints: bool = True,
) -> None:
    """Check an algorithm by short runs on small problems.

    Parameters
    ----------
    algorithm : a class that can be made without arguments, or an instance that has not been set
        up; it is left as it is.
    seed : of the runs.
    n_gen : generations per run, at least 3.
    n_var : variables of the problems.
    n_obj : numbers of objectives it claims to treat.
    constraints : whether it claims to treat inequality constraints.

    Raises
    ------
    CheckError : for the first rule that is broken.

    Examples
    --------
    >>> from pymoo.algorithms.moo.nsga2 import NSGA2
    >>> from mgeo.testing import check_algorithm
    >>> check_algorithm(NSGA2(20), n_gen=3)
    """
    if isinstance(algorithm, type):
        with no_error(f"{algorithm.__name__}() must be constructible without arguments"):
            algorithm = algorithm()
    require(isinstance(algorithm, Algorithm), f"{algorithm!r} is not a pymoo Algorithm")
    require(algorithm.problem is None, "the algorithm has been set up: expected a fresh one")
    for count in n_obj:
        trial = _Trial(algorithm, Bowls(n_var, count), seed, n_gen)
        result, visited = trial.run()
        _check_result(trial, result, visited)
        _check_seeds(trial, result, visited)
        _check_ask_and_tell(trial, result)
        _check_copies(trial, result)
        if isinstance(algorithm, ExtremalOptimization):
            _check_parameters(trial, result)
            _check_restored(trial, result)
        if constraints:
            _check_constraints(trial)


@dataclass(frozen=True)
class _Trial:
    algorithm: Algorithm
    problem: Bowls
    seed: int
    n_gen: int

    def run(self, **options: Any) -> tuple[Result, FloatArray]:
        """A run by `minimize`: its result, and all points evaluated, in order."""
        self.problem.seen.clear()
        with no_error(f"minimize with {self.problem.n_obj} objectives"):
            result = minimize(self.problem, self.algorithm, **self._options(), **options)
        require(self.algorithm.problem is None, "minimize must leave the algorithm as it was")
        return result, np.concatenate(self.problem.seen)

    def set_up(self, generations: int = 0) -> Algorithm:
        """Return a copy of the algorithm after some generations, to be run step by step."""
        run = copy.deepcopy(self.algorithm).setup(self.problem, **self._options())
        for _ in range(generations):
            run.next()
        return run

    def _options(self) -> dict[str, Any]:
        return {"termination": ("n_gen", self.n_gen), "seed": self.seed}


def _require_same(found: Any, expected: Result, rule: str) -> None:
    """Compare points and objectives of two results (or of an algorithm's optimum and a result)."""
    opt = found.opt
    require(opt is not None and len(opt) > 0, f"{rule}: no solution was found this time")
    for key in ("X", "F"):
        require_equal(opt.get(key), expected.opt.get(key), f"{rule}: {key}")


def _check_result(trial: _Trial, result: Result, visited: FloatArray) -> None:
    problem, where = trial.problem, f"{trial.problem.n_obj} objectives"
    inside = (visited >= problem.xl) & (visited <= problem.xu)
    require(inside.all(), f"{where}: points out of bounds were evaluated: {visited[~inside][:3]}")
    count = result.algorithm.evaluator.n_eval
    require(count == len(visited), f"{where}: n_eval = {count} after {len(visited)} evaluations")
    require(result.X is not None, f"{where}: nothing was found")
    X, F = np.atleast_2d(result.X), np.atleast_2d(result.F)
    require_equal(F, problem.evaluate(X), f"{where}: res.F must be the objectives of res.X", 1e-12)
    distinct = np.unique(F, axis=0)
    dominated = distinct[~nondominated(distinct)]
    require(len(dominated) == 0, f"{where}: points of res.F are dominated: {dominated[:3]}")
    if problem.n_obj == 1:
        require(result.X.shape == (problem.n_var,), f"{where}: res.X of shape {result.X.shape}")


def _check_seeds(trial: _Trial, result: Result, visited: FloatArray) -> None:
    before = _global_state()
    again, revisited = trial.run()
    require_equal(revisited, visited, "same seed, same points")
    _require_same(again, result, "same seed, same result")
    _, elsewhere = replace(trial, seed=trial.seed + 1).run()
    require(not np.array_equal(visited, elsewhere), "another seed, the same points")
    require(
        _global_state() == before, "numpy's global random state was used: draw from random_state"
    )


def _global_state() -> bytes:
    # The legacy state is not used here, only watched.
    return pickle.dumps(np.random.get_state())  # noqa: NPY002


def _check_ask_and_tell(trial: _Trial, result: Result) -> None:
    with no_error("ask and tell"):
        asked = trial.set_up()
        while asked.has_next():
            infills = asked.ask()
            asked.evaluator.eval(trial.problem, infills)
            asked.tell(infills=infills)
    _require_same(asked, result, "ask and tell, as minimize")


def _check_copies(trial: _Trial, result: Result) -> None:
    with no_error("deepcopy in the middle of a run"):
        run = trial.set_up(2)
        duplicate = copy.deepcopy(run)
        _require_same(run.run(), result, "a run that was copied midway")
        _require_same(duplicate.run(), result, "the copy of a run made midway")
    with no_error("pickle the algorithm"):
        revived = pickle.loads(pickle.dumps(trial.algorithm))
    _require_same(replace(trial, algorithm=revived).run()[0], result, "a pickled copy, as itself")


def _check_parameters(trial: _Trial, result: Result) -> None:
    cls = type(trial.algorithm)
    with no_error("get_params(), each parameter of the constructor kept under its name"):
        found = trial.algorithm.get_params()
        again = cls(**found)
    for name, value in again.get_params().items():
        require(
            np.array_equal(value, found[name]),
            f"{cls.__name__}({name}={found[name]!r:.80}) keeps {name} = {value!r:.80}: expected "
            "each parameter to be kept as it was given",
        )
    rule = "an algorithm made from get_params(), as itself"
    _require_same(replace(trial, algorithm=again).run()[0], result, rule)


def _check_restored(trial: _Trial, result: Result) -> None:
    try:
        saved = capture(trial.set_up(2))
    except TypeError:  # it says itself that it cannot be kept
        return
    with no_error("a run that was kept and restored midway"):
        restored = restore(saved, trial.problem, trial.algorithm)
        _require_same(restored.run(), result, "a run that was kept and restored midway")


def _check_constraints(trial: _Trial) -> None:
    sizes = trial.problem.n_var, trial.problem.n_obj
    half, _ = replace(trial, problem=Bowls(*sizes, "half")).run()
    require(half.X is not None, "half of the points are feasible: none was found")
    require(np.all(np.atleast_2d(half.X)[:, 0] >= 0), f"infeasible points returned: {half.X}")
    impossible = replace(trial, problem=Bowls(*sizes, "impossible"))
    none, _ = impossible.run()
    require(none.X is None, f"no point is feasible: expected res.X None, got {none.X}")
    least, _ = impossible.run(return_least_infeasible=True)
    require(least.X is not None, "return_least_infeasible: expected a point")


class Bowls(Problem):
    """Squared distances to n_obj centers within [-2, 2]^n_var; they conflict.

    Parameters
    ----------
    n_var, n_obj : numbers of variables and objectives.
    constraint : "half" the points are feasible (x_1 >= 0), or none is ("impossible").
    """

    def __init__(self, n_var: int = 4, n_obj: int = 2, constraint: Constraint = "none") -> None:
        super().__init__(
            n_var=n_var, n_obj=n_obj, n_ieq_constr=int(constraint != "none"), xl=-2.0, xu=2.0
        )
        self.constraint = constraint
        self.seen: list[FloatArray] = []
        self.centers = np.zeros((n_obj, n_var))
        self.centers[np.arange(n_obj), np.arange(n_obj) % n_var] = np.linspace(-1.0, 1.0, n_obj)

    def _evaluate(self, X: FloatArray, out: dict[str, Any], *args: Any, **kwargs: Any) -> None:
        self.seen.append(X.copy())
        out["F"] = np.sum((X[:, None, :] - self.centers) ** 2, axis=2)
        if self.constraint == "half":
            out["G"] = -X[:, :1]
        elif self.constraint == "impossible":
            out["G"] = 3.0 + X[:, :1]
