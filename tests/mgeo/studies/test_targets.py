"""Runtimes to targets, against a plain loop over runs and targets."""

import math
from types import SimpleNamespace

import numpy as np
import pandas as pd

from mgeo.studies.pooled import SHORTFALLS, runtimes, targets_reached


def results(values, n_var=4, name="hypervolume", runs=None):
    """Of {(algorithm, seed): hypervolumes after 40, 80, ... evaluations}."""
    rows = [
        {"algorithm": a, "seed": seed, "evaluations": 40 * (i + 1), "hypervolume": v}
        for (a, seed), trace in values.items()
        for i, v in enumerate(trace)
    ]
    made = pd.DataFrame(runs or list(values), columns=["algorithm", "seed"])
    return SimpleNamespace(
        table=pd.DataFrame(rows),
        runs=made,
        algorithms=tuple(dict.fromkeys(made["algorithm"])),
        problem=SimpleNamespace(n_var=n_var, n_obj=2),
        indicator=lambda: SimpleNamespace(name=name),
    )


def plainly(values, n_var, best):
    found = {}
    for (algorithm, _), trace in values.items():
        for shortfall in SHORTFALLS:
            reached = [40 * (i + 1) for i, v in enumerate(trace) if v >= best - shortfall * best]
            found.setdefault(algorithm, []).append(reached[0] / n_var if reached else math.inf)
    return {name: sorted(times) for name, times in found.items()}


def test_runtimes_are_those_of_a_plain_loop():
    rng = np.random.default_rng(0)
    values = {
        (a, seed): np.sort(1.0 - 10.0 ** rng.uniform(-6, 0, 7))
        for a in ("one", "two", "three")
        for seed in (1, 2)
    }
    best = max(trace[-1] for trace in values.values())
    found, expected = runtimes({"p": results(values)}), plainly(values, 4, best)
    assert found.keys() == expected.keys()
    for name, times in expected.items():
        assert np.array_equal(found[name], times)


def test_problems_are_pooled_by_evaluations_per_variable():
    values = {("a", 1): [0.0, 1.0]}
    found = runtimes({"p": results(values, n_var=4), "q": results(values, n_var=8)})["a"]
    assert found.tolist() == [10.0] * len(SHORTFALLS) + [20.0] * len(SHORTFALLS)


def test_a_run_that_failed_or_found_nothing_reaches_no_target():
    values = {("a", 1): [0.5, 1.0], ("b", 1): [0.0, 0.0]}
    made = results(values, runs=[("a", 1), ("a", 2), ("b", 1), ("c", 1)])
    found = runtimes({"p": made})
    assert np.isfinite(found["a"]).sum() == len(SHORTFALLS)
    assert len(found["a"]) == 2 * len(SHORTFALLS)
    assert np.isinf(found["b"]).all()
    assert np.isinf(found["c"]).all()


def test_nobody_reaches_a_target_where_nobody_reached_anything():
    nothing = results({("a", 1): [0.0, 0.0], ("b", 1): [0.0, 0.0]})
    assert targets_reached({"p": nothing})["share"].tolist() == [0.0, 0.0]
    both = targets_reached({"p": nothing, "q": results({("a", 1): [0.0, 1.0], ("b", 1): [0, 0]})})
    assert both["share"].tolist() == [0.5, 0.0]


def test_there_are_no_targets_without_a_hypervolume():
    made = results({("a", 1): [1.0]}, name="best_value")
    assert runtimes({"p": made}) == {}
    assert targets_reached({"p": made}).empty
