"""One run of an algorithm on a problem, in a line."""

from mgeo.runs.algorithms import set_up
from mgeo.runs.solve import SolveState
from mgeo.runs.solve import solve as run


def solve(problem, algorithm, evaluations, seed, callback=None, max_time=None):
    ready = set_up(problem, algorithm, evaluations, seed)
    return run(SolveState(ready, evaluations, callback, max_time=max_time))
