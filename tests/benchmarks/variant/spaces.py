"""Problems as an algorithm sees them here, with all that it evaluates kept."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from moocore import hypervolume
from numpy.typing import NDArray
from pymoo.core.problem import Problem
from pymoo.problems import get_problem

from mgeo.pareto.dominance import nondominated

from ..cases import FORMER_PAPER

Floats = NDArray[np.float64]

RAW, INDICATOR = "raw", "indicator"


class Watched(Problem):
    """A problem that keeps every objective vector, in order of evaluation.

    With `space` = "indicator" the algorithm is given the objectives of the problem's indicator
    space in place of its own; what is kept are the problem's own in either case.
    """

    def __init__(self, problem: Problem, space: str = RAW) -> None:
        super().__init__(
            n_var=problem.n_var,
            n_obj=problem.n_obj,
            n_ieq_constr=problem.n_ieq_constr,
            xl=problem.xl,
            xu=problem.xu,
            vtype=float,
        )
        if space not in (RAW, INDICATOR):
            raise ValueError(f"space = {space!r}: expected {RAW!r} or {INDICATOR!r}")
        self.problem = problem
        self.space = space
        self.seen: list[Floats] = []

    def _evaluate(self, X, out, *args, **kwargs):
        F = self.problem.evaluate(X, return_values_of=["F"])
        self.seen.append(F)
        out["F"] = self.problem.indicator_space(F) if self.space == INDICATOR else F


class Scale:
    """Hypervolume in the space in which solutions of a problem are compared, up to (r, ..., r).

    That is the problem's own indicator space and r = 1; or, for a test problem, objectives in
    which its true front reaches from 0 to 1, and r = 1.1.
    """

    def __init__(self, problem: Problem) -> None:
        self._to_space = getattr(problem, "indicator_space", None)
        self.reference = 1.0
        if self._to_space is None:
            front = true_front(problem)
            ideal, nadir = front.min(axis=0), front.max(axis=0)
            self._to_space = lambda F: (F - ideal) / (nadir - ideal)
            self.reference = 1.1

    def hypervolume(self, F: Floats) -> tuple[float, int]:
        """Of all points that none of `F` dominates, and how many those are."""
        front = F[nondominated(F)]
        points = self._to_space(front)
        return float(hypervolume(points, ref=[self.reference] * points.shape[1])), len(front)


def true_front(problem: Problem) -> Floats:
    """At least the ends of a test problem's true front."""
    if problem.name() == "DTLZ7":
        return dtlz7_front()
    if problem.name().startswith("WFG"):  # pymoo draws some of these at random, without a seed
        return np.diag(2.0 * np.arange(1, problem.n_obj + 1))  # 2 m (Huband et al. 2006)
    return problem.pareto_front()


def dtlz7_front() -> Floats:
    """The front of DTLZ7 with three objectives, which pymoo would have to download."""
    f = np.stack(np.meshgrid(*[np.linspace(0.0, 1.0, 201)] * 2), axis=-1).reshape(-1, 2)
    last = 2.0 * (3.0 - (f / 2.0 * (1.0 + np.sin(3.0 * np.pi * f))).sum(axis=1))
    front = np.column_stack([f, last])
    return front[nondominated(front)]


def problem_by_name(name: str) -> Problem:
    """A test problem of pymoo, or the attitude problem on one thread.

    "attitude" is the paper's preset with its former 1 % of convergence; "attitude-coarse" has steps
    of 4 s and is four times as fast.
    """
    if name in ("attitude", "attitude-coarse"):
        from mgeo_attitude import AttitudeManeuverProblem, Scenario

        scenario = Scenario.from_toml(FORMER_PAPER)
        step = 4.0 if name == "attitude-coarse" else 1.0
        return AttitudeManeuverProblem(replace(scenario, step=step), threads=1)
    if name.startswith("wfg"):
        return get_problem(name, n_var=24, n_obj=2)
    if name.startswith("dtlz"):
        return get_problem(name, n_var={"dtlz1": 7, "dtlz2": 12, "dtlz7": 22}[name], n_obj=3)
    return get_problem(name)
