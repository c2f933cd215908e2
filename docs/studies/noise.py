"""Quality of the fronts that algorithms find if all objectives are noisy.

    .venv/bin/python docs/studies/noise.py [SEEDS]

from the folder above docs writes data/noise.csv. The table contains the hypervolume of the exact
objectives of the points that form the front by their noisy objectives.
"""

import sys
from pathlib import Path

import numpy as np
import pandas as pd
from moocore import hypervolume
from pymoo.core.problem import Problem

from mgeo.plugins.problems import load_problem
from mgeo.runs.algorithms import build_algorithm
from mgeo.studies.run import Task, record_run

EVALUATIONS = 3_000
LEVELS = (0.0, 0.05)  # Standard deviations as a fraction of the extent of the front.
PROBLEMS = tuple(f"shifted:wfg{i}" for i in range(1, 10))
EXTENT = (2.0, 4.0)  # Extent of the fronts of all problems.
RIVALS = ("nsga2", "nsga3", "moead", "spea2", "cmopso")
ALGORITHMS = {"MGEO directed (ours)": "mgeo-directed"} | {name: name for name in RIVALS}


class Noisy(Problem):
    """Problem that adds normal noise to the objectives of another problem.

    The random generator is seeded by the point, so that equal points have equal noise and runs are
    repeatable. No algorithm can therefore profit from repeated evaluations of a point, and none of
    the compared algorithms makes them.
    """

    def __init__(self, inner, deviations):
        super().__init__(
            n_var=inner.n_var, n_obj=inner.n_obj, xl=inner.xl, xu=inner.xu, vtype=float
        )
        self.inner, self.deviations = inner, np.asarray(deviations, dtype=float)

    def _evaluate(self, X, out, *args, **kwargs):
        points = np.ascontiguousarray(X, dtype=float)
        drawn = [
            np.random.default_rng(list(x.tobytes())).standard_normal(self.n_obj) for x in points
        ]
        out["F"] = self.inner.evaluate(points) + self.deviations * np.array(drawn)


def quality(name, algorithm, level, seed):
    """Return the hypervolume of the exact objectives of a noisy front, scaled by the extent."""
    inner = load_problem(name, {"n_var": 10, "n_obj": 2})
    parameters = {} if algorithm == "mgeo-directed" else {"population": 100}
    problem = Noisy(inner, level * np.array(EXTENT))
    run = record_run(
        Task(problem, build_algorithm(algorithm, parameters, problem), EVALUATIONS, seed)
    )
    return hypervolume(inner.evaluate(run.X) / EXTENT, ref=np.full(2, 1.1))


def main():
    seeds = range(1, 1 + (int(sys.argv[1]) if len(sys.argv) > 1 else 2))
    rows = [
        (name, level, label, seed, quality(name, algorithm, level, seed))
        for name in PROBLEMS
        for level in LEVELS
        for label, algorithm in ALGORITHMS.items()
        for seed in seeds
    ]
    table = pd.DataFrame(rows, columns=["problem", "noise", "algorithm", "seed", "hypervolume"])
    target = Path(__file__).parent / "data" / "noise.csv"
    table.to_csv(target, index=False, lineterminator="\n", float_format="%.6g")
    print(table.pivot_table("hypervolume", "algorithm", ["problem", "noise"]).round(3).to_string())


if __name__ == "__main__":
    main()
