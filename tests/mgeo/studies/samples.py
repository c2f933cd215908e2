"""Small comparisons with prescribed values."""

import numpy as np
import pandas as pd
from pymoo.problems.multi import ZDT1

from mgeo.studies.comparison import Comparison
from mgeo.studies.indicators import build_indicator_space
from mgeo.studies.study_run import StudyRun

VALUES = {"A_1": [0.5, 0.6, 0.7], "B": [0.1, 0.2, 0.3], "C": [0.5, 0.65, 0.2]}
FRONTS = {
    "A_1": [[[1.0, 2.0], [2.0, 1.0]], [[1.0, 2.0]], [[1.0, 2.0]]],
    "B": [[[2.0, 3.0]], [[2.0, 3.0]], [[1.0, 2.0]]],
    "C": [[[1.0, 2.0], [2.0, 1.0]], [[1.0, 2.0]], [[1.0, 2.0]]],
}


def build_run(F):
    points = np.array(F)
    rows = np.arange(len(points))
    return StudyRun(rows + 1, points, rows, np.empty((len(points), 0)), 100, 100, 0, 1.0)


def build_comparison(problem=None):
    """Return a comparison of three algorithms and seeds, after 50 and 100 evaluations."""
    rows = [
        {
            "algorithm": name,
            "seed": seed,
            "evaluations": n,
            "hypervolume": value * n / 100,
            "igd_plus": 1 - value,
            "epsilon": 0.25,
            "points": 10 * seed,
        }
        for name, values in VALUES.items()
        for seed, value in enumerate(values, 1)
        for n in (50, 100)
    ]
    finished_runs = {
        (name, seed): build_run(F)
        for name, fronts in FRONTS.items()
        for seed, F in enumerate(fronts, 1)
    }
    problem = problem or ZDT1()
    space = build_indicator_space(problem, [run.front_F for run in finished_runs.values()])
    table, runs = pd.DataFrame(rows), pd.DataFrame()
    return Comparison(problem, tuple(VALUES), 100, table, runs, finished_runs, space)


def build_final_comparison(values):
    """Return a comparison with prescribed final hypervolumes by algorithm; 0 is an empty front."""
    rows = [
        {"algorithm": name, "seed": seed, "evaluations": 100, "hypervolume": v}
        | {"igd_plus": 1 - v if v else np.inf, "epsilon": 1 - v if v else np.inf}
        | {"points": 9 if v else 0}
        for name, column in values.items()
        for seed, v in enumerate(column, 1)
    ]
    table = pd.DataFrame(rows)
    return Comparison(**{**vars(build_comparison()), "table": table, "algorithms": tuple(values)})
