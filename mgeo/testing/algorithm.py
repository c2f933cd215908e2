"""Check in short runs that a pymoo algorithm meets the requirements of studies."""

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
from mgeo.evaluation.dominance import find_nondominated
from mgeo.testing.check import convert_to_check_error, require, require_equal

Constraint = Literal["none", "half", "impossible"]


def check_algorithm(
    algorithm: Algorithm | type[Algorithm],
    seed: int = 1,
    n_gen: int = 5,
    n_var: int = 4,
    n_obj: tuple[int, ...] = (1, 2, 3),
    constraints: bool = True,
) -> None:
    """Check an algorithm in short runs, and raise CheckError for the first violated rule.

    The checks cover bounds, evaluation counts, the reported front, reproducibility by seed, ask and
    tell, copies and pickles, and constraints. For algorithms of the MGEO family they also cover
    `get_params`, and saving and restoring a run.

    Parameters
    ----------
    algorithm : Algorithm or type
        Instance before `setup`, which is not modified, or a class whose constructor needs no
        arguments.
    seed : int
        Random seed of the runs.
    n_gen : int
        Generations per run, at least 3.
    n_var : int
        Number of variables of the problems.
    n_obj : tuple of int
        Numbers of objectives to check; leave out those that the algorithm does not support.
    constraints : bool
        False for an algorithm that does not support inequality constraints.

    Raises
    ------
    CheckError
        For the first rule that the algorithm violates.

    Examples
    --------
    >>> from pymoo.algorithms.moo.nsga2 import NSGA2
    >>> from mgeo.testing import check_algorithm
    >>> check_algorithm(NSGA2(20), n_gen=3)
    """
    if isinstance(algorithm, type):
        with convert_to_check_error(
            f"{algorithm.__name__}() must be constructible without arguments"
        ):
            algorithm = algorithm()
    require(isinstance(algorithm, Algorithm), f"{algorithm!r} is not a pymoo Algorithm")
    require(
        algorithm.problem is None,
        "the algorithm has been set up: expected an algorithm before setup()",
    )
    for count in n_obj:
        trial = _Trial(algorithm, Bowls(n_var, count), seed, n_gen)
        result, visited = trial.run()
        _check_result(trial, result, visited)
        _check_reproducibility(trial, result, visited)
        _check_ask_and_tell(trial, result)
        _check_copies(trial, result)
        if isinstance(algorithm, ExtremalOptimization):
            _check_parameters(trial, result)
            _check_restore(trial, result)
        if constraints:
            _check_constraints(trial)


@dataclass(frozen=True)
class _Trial:
    algorithm: Algorithm
    problem: Bowls
    seed: int
    n_gen: int

    def run(self, **options: Any) -> tuple[Result, FloatArray]:
        """Run the algorithm, and return its result and all evaluated points in order."""
        self.problem.batches.clear()
        with convert_to_check_error(f"minimize with {self.problem.n_obj} objectives"):
            result = minimize(self.problem, self.algorithm, **self._get_options(), **options)
        require(self.algorithm.problem is None, "minimize must leave the algorithm as it was")
        return result, np.concatenate(self.problem.batches)

    def set_up(self, generations: int = 0) -> Algorithm:
        """Return a copy of the algorithm after a given number of generations."""
        run = copy.deepcopy(self.algorithm).setup(self.problem, **self._get_options())
        for _ in range(generations):
            run.next()
        return run

    def _get_options(self) -> dict[str, Any]:
        return {"termination": ("n_gen", self.n_gen), "seed": self.seed}


def _require_same(actual: Any, expected: Result, rule: str) -> None:
    """Raise CheckError unless two runs found the same points with the same objectives."""
    opt = actual.opt
    require(opt is not None and len(opt) > 0, f"{rule}: the repeated run found no solution")
    for key in ("X", "F"):
        require_equal(opt.get(key), expected.opt.get(key), f"{rule}: {key}")


def _check_result(trial: _Trial, result: Result, points: FloatArray) -> None:
    problem, where = trial.problem, f"{trial.problem.n_obj} objectives"
    is_inside = (points >= problem.xl) & (points <= problem.xu)
    require(
        is_inside.all(), f"{where}: points out of bounds were evaluated: {points[~is_inside][:3]}"
    )
    count = result.algorithm.evaluator.n_eval
    require(count == len(points), f"{where}: n_eval = {count} after {len(points)} evaluations")
    require(result.X is not None, f"{where}: no solution was found")
    X, F = np.atleast_2d(result.X), np.atleast_2d(result.F)
    require_equal(F, problem.evaluate(X), f"{where}: res.F must be the objectives of res.X", 1e-12)
    distinct = np.unique(F, axis=0)
    dominated = distinct[~find_nondominated(distinct)]
    require(len(dominated) == 0, f"{where}: points of res.F are dominated: {dominated[:3]}")
    if problem.n_obj == 1:
        require(result.X.shape == (problem.n_var,), f"{where}: res.X of shape {result.X.shape}")


def _check_reproducibility(trial: _Trial, result: Result, points: FloatArray) -> None:
    state_before = _read_global_state()
    repeated_result, repeated_points = trial.run()
    require_equal(repeated_points, points, "same seed, same points")
    _require_same(repeated_result, result, "same seed, same result")
    _, points_of_other_seed = replace(trial, seed=trial.seed + 1).run()
    require(
        not np.array_equal(points, points_of_other_seed),
        "another seed, the same points: expected other points",
    )
    require(
        _read_global_state() == state_before,
        "numpy's global random state was used: draw from random_state",
    )


def _read_global_state() -> bytes:
    # The legacy state is only compared, never used to draw numbers.
    return pickle.dumps(np.random.get_state())  # noqa: NPY002


def _check_ask_and_tell(trial: _Trial, result: Result) -> None:
    with convert_to_check_error("ask and tell"):
        algorithm = trial.set_up()
        while algorithm.has_next():
            infills = algorithm.ask()
            algorithm.evaluator.eval(trial.problem, infills)
            algorithm.tell(infills=infills)
    _require_same(algorithm, result, "a run with ask and tell must equal a run with minimize")


def _check_copies(trial: _Trial, result: Result) -> None:
    with convert_to_check_error("deepcopy in the middle of a run"):
        run = trial.set_up(2)
        duplicate = copy.deepcopy(run)
        _require_same(run.run(), result, "a run must not change when it is copied midway")
        _require_same(duplicate.run(), result, "a copy made midway must continue as the run does")
    with convert_to_check_error("pickle the algorithm"):
        unpickled = pickle.loads(pickle.dumps(trial.algorithm))
    rule = "a pickled copy must run as the algorithm itself"
    _require_same(replace(trial, algorithm=unpickled).run()[0], result, rule)


def _check_parameters(trial: _Trial, result: Result) -> None:
    cls = type(trial.algorithm)
    with convert_to_check_error(
        "get_params() needs each constructor parameter as an attribute of the same name"
    ):
        params = trial.algorithm.get_params()
        duplicate = cls(**params)
    for name, value in duplicate.get_params().items():
        require(
            np.array_equal(value, params[name]),
            f"{cls.__name__}({name}={params[name]!r:.80}) has {name} = {value!r:.80}: expected "
            "the attribute to equal the constructor argument",
        )
    rule = "an algorithm built from get_params() must run as the original"
    _require_same(replace(trial, algorithm=duplicate).run()[0], result, rule)


def _check_restore(trial: _Trial, result: Result) -> None:
    try:
        saved = capture(trial.set_up(2))
    except TypeError:  # The algorithm cannot be saved, and `capture` reports it.
        return
    with convert_to_check_error("a run that was saved and restored midway"):
        restored = restore(saved, trial.problem, trial.algorithm)
        _require_same(restored.run(), result, "a run that was saved and restored midway")


def _check_constraints(trial: _Trial) -> None:
    sizes = trial.problem.n_var, trial.problem.n_obj
    half, _ = replace(trial, problem=Bowls(*sizes, "half")).run()
    require(
        half.X is not None, "half of the points are feasible, but the run found no feasible point"
    )
    require(np.all(np.atleast_2d(half.X)[:, 0] >= 0), f"infeasible points returned: {half.X}")
    impossible = replace(trial, problem=Bowls(*sizes, "impossible"))
    none, _ = impossible.run()
    require(none.X is None, f"no point is feasible: expected res.X None, got {none.X}")
    least, _ = impossible.run(return_least_infeasible=True)
    require(least.X is not None, "return_least_infeasible: expected a point")


class Bowls(Problem):
    """Test problem whose objectives are squared distances to center points.

    All variables are in [-2, 2].

    Parameters
    ----------
    n_var, n_obj : int
        Numbers of variables and objectives.
    constraint : {"none", "half", "impossible"}
        Constraint that all points, half of the points (x_1 >= 0) or no points satisfy.

    Attributes
    ----------
    batches : list of arrays, shape (n, n_var)
        Evaluated points, one array per batch.
    """

    def __init__(self, n_var: int = 4, n_obj: int = 2, constraint: Constraint = "none") -> None:
        super().__init__(
            n_var=n_var, n_obj=n_obj, n_ieq_constr=int(constraint != "none"), xl=-2.0, xu=2.0
        )
        self.constraint = constraint
        self.batches: list[FloatArray] = []
        self.centers = np.zeros((n_obj, n_var))
        self.centers[np.arange(n_obj), np.arange(n_obj) % n_var] = np.linspace(-1.0, 1.0, n_obj)

    def _evaluate(self, X: FloatArray, out: dict[str, Any], *args: Any, **kwargs: Any) -> None:
        self.batches.append(X.copy())
        out["F"] = np.sum((X[:, None, :] - self.centers) ** 2, axis=2)
        if self.constraint == "half":
            out["G"] = -X[:, :1]
        elif self.constraint == "impossible":
            out["G"] = 3.0 + X[:, :1]
