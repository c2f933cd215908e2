"""One run of an algorithm on a problem, in a line."""

from mgeo.runs.solve import follow, set_up


def solve(problem, algorithm, evaluations, seed, callback=None, persistence=None):
    ready = set_up(problem, algorithm, evaluations, seed)
    return follow(problem, ready, evaluations, callback, persistence)
