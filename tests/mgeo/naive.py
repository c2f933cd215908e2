"""Slow twins written from the papers' words: one loop per sentence, no arrays of walkers."""

import math

import numpy as np


def dominates(a, b):
    return all(x <= y for x, y in zip(a, b, strict=True)) and any(
        x < y for x, y in zip(a, b, strict=True)
    )


def nondominated_rows(F):
    """Rows of the exact front, first of equals, in the order found."""
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
    """Rows a `ParetoArchive` holds after seeing all of them, in its order."""
    able = [
        i
        for i, f in enumerate(F)
        if all(math.isfinite(v) for v in f) and not math.isnan(violation[i])
    ]
    if not able:
        return []
    least = min(violation[i] for i in able)
    best = [i for i in able if violation[i] == least]
    front = [best[k] for k in nondominated_rows([F[i] for i in best])]
    return sorted(front, key=lambda i: F[i][0])  # stable: found first stays first


def walk(problem, seed, walker, generations, sigma, tau, perturbation):
    """One walker of MGEO_real on its own, drawing from child `walker` of the seed.

    Returns the positions after each generation and all candidates with objectives and violations.
    """
    stream = np.random.default_rng(np.random.SeedSequence(seed).spawn(walker + 1)[walker])
    xl, xu = problem.xl.tolist(), problem.xu.tolist()
    n = problem.n_var
    sigmas = np.broadcast_to(sigma, n).tolist()
    x = [xl[i] + (xu[i] - xl[i]) * u for i, u in enumerate(stream.random(n).tolist())]
    path, candidates, objectives, violations = [], [], [], []
    for _ in range(generations):
        noise = stream.standard_normal(n).tolist()
        trials = []
        for i in range(n):
            scale = {"absolute": 1.0, "relative": x[i], "range": xu[i] - xl[i]}[perturbation]
            trial = list(x)
            trial[i] = min(max(x[i] + sigmas[i] * scale * noise[i], xl[i]), xu[i])
            trials.append(trial)
        values = [_values(problem, trial) for trial in trials]
        candidates += trials
        objectives += [f for f, _ in values]
        violations += [v for _, v in values]
        chosen = int(stream.random() * problem.n_obj)
        ties = stream.random(n).tolist()
        ranking = sorted(range(n), key=lambda i: (*_merit(*values[i], chosen), ties[i]))
        rank = _inverse_of_power_law(stream.random(), n, tau)
        x = trials[ranking[rank - 1]]
        path.append(list(x))
    return path, candidates, objectives, violations


def _values(problem, x):
    out = problem.evaluate(
        np.array([x]), return_values_of=["F", "G", "H"], return_as_dictionary=True
    )
    violation = sum(max(0.0, g) for g in out["G"][0].tolist())
    violation += sum(max(0.0, abs(h) - 1e-4) for h in out["H"][0].tolist())
    return out["F"][0].tolist(), violation


def _merit(f, violation, chosen):
    if not all(math.isfinite(v) for v in f) or math.isnan(violation):
        return (2, 0.0)
    return (1, violation) if violation > 0 else (0, f[chosen])


def _inverse_of_power_law(u, n, tau):
    total = sum(k**-tau for k in range(1, n + 1))
    reached = 0.0
    for k in range(1, n + 1):
        reached += k**-tau
        if u * total < reached:
            return k
    return n


def rejection_rank(rng, n, tau):
    """The usual wording: draw a rank, accept it with probability k^-tau, else draw again."""
    while True:
        k = int(rng.integers(1, n + 1))
        if rng.random() <= k**-tau:
            return k


def geo_minimum(f, xl, xu, generations, sigma, tau, rng):
    """Best value of one run of one-objective GEO_real with a relative perturbation."""
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
