"""Function that runs an algorithm on a problem, as ``mgeo solve`` does."""

from mgeo.runs.algorithms import set_up
from mgeo.runs.solve import SolveState
from mgeo.runs.solve import solve as run


def solve(problem, algorithm, evaluations, seed, callback=None, max_time=None):
    prepared = set_up(problem, algorithm, evaluations, seed)
    return run(SolveState(prepared, evaluations, callback, max_time=max_time))
