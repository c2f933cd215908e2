"""Reference implementations in plain Python loops, written from the definitions in the papers."""

import math
from operator import le, lt


def dominates(a, b):
    assert len(a) == len(b)
    return all(map(le, a, b)) and any(map(lt, a, b))


def nondominated_rows(F):
    """Return the rows of the nondominated vectors in ascending order, the first of equal ones."""
    finite = [i for i, f in enumerate(F) if all(math.isfinite(v) for v in f)]
    front = []
    for i in finite:
        if any(dominates(F[j], F[i]) for j in finite):
            continue
        if any(tuple(F[j]) == tuple(F[i]) for j in front):
            continue
        front.append(i)
    return front


def archive_rows(F, violation):
    """Return the rows of the points that a `ParetoArchive` of all points contains, in its order."""
    valid = [
        i
        for i, f in enumerate(F)
        if all(math.isfinite(v) for v in f) and not math.isnan(violation[i])
    ]
    if not valid:
        return []
    least = min(violation[i] for i in valid)
    best = [i for i in valid if violation[i] == least]
    front = [best[k] for k in nondominated_rows([F[i] for i in best])]
    return sorted(front, key=lambda i: F[i][0])  # The sort is stable.


def rejection_rank(rng, n, tau):
    """Draw a rank by rejection: accept a uniform rank k with probability k^-tau, or draw again."""
    while True:
        k = int(rng.integers(1, n + 1))
        if rng.random() <= k**-tau:
            return k


def geo_minimum(f, xl, xu, generations, sigma, tau, rng):
    """Return the best value of a run of single-objective GEO_real with relative perturbation."""
    n = len(xl)
    x = [xl[i] + (xu[i] - xl[i]) * rng.random() for i in range(n)]
    best = math.inf
    for _ in range(generations):
        trials = []
        for i in range(n):
            trial = list(x)
            trial[i] = min(max(x[i] + sigma * x[i] * rng.standard_normal(), xl[i]), xu[i])
            trials.append((f(trial), i, trial))
        trials.sort()
        best = min(best, trials[0][0])
        x = trials[rejection_rank(rng, n, tau) - 1][2]
    return best
