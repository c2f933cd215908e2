"""Ranks and runtimes against plain loops, and the test of ranks against its exact distribution."""

import math
from itertools import product
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from mgeo.studies.aggregation import (
    TARGET_DISTANCES,
    compute_average_ranks,
    compute_friedman_test,
    compute_problem_values,
    compute_runtime_distribution,
    compute_runtimes,
)
from mgeo.studies.indicators import BEST_VALUE, INDICATORS

NAMES = ("one", "two", "three")


def pooled(given, per_variable=False, control=None):
    return compute_average_ranks(compute_problem_values(given, per_variable), control)


def results(values, n_var=4, epsilon=None, function_name="", runs=None, indicator=INDICATORS[0]):
    """Of {(algorithm, seed): hypervolumes after 40, 80, ... evaluations}."""
    rows = [
        {
            "algorithm": name,
            "seed": seed,
            "evaluations": 10 * n_var * (i + 1),
            "hypervolume": value,
            "epsilon": np.inf if epsilon is None else epsilon[name, seed][i],
        }
        for (name, seed), trace in values.items()
        for i, value in enumerate(trace)
    ]
    made = pd.DataFrame(runs or list(values), columns=["algorithm", "seed"])
    return SimpleNamespace(
        table=pd.DataFrame(rows),
        runs=made,
        algorithms=tuple(dict.fromkeys(made["algorithm"])),
        problem=SimpleNamespace(n_var=n_var, function_name=function_name),
        select_indicator=lambda: indicator,
    )


def many(rng, n, **options):
    return {
        str(k): results(
            {(name, seed): rng.random(2) for name in NAMES for seed in (1, 2, 3)}, **options
        )
        for k in range(n)
    }


def test_ranks_are_those_of_a_plain_loop():
    given = many(np.random.default_rng(1), 6)
    found = pooled(given)
    assert found["evaluations"].unique().tolist() == [40, 80]
    assert set(found["variables"]) == {0}
    for evaluations, group in found.groupby("evaluations"):
        ranks = dict.fromkeys(NAMES, 0.0)
        for each in given.values():
            now = each.table[each.table["evaluations"] == evaluations]
            medians = {n: now[now["algorithm"] == n]["hypervolume"].median() for n in NAMES}
            for place, name in enumerate(sorted(NAMES, key=medians.get, reverse=True)):
                ranks[name] += (place + 1) / 6
        assert group["algorithm"].tolist() == sorted(NAMES, key=ranks.get)
        assert group["average_rank"].tolist() == pytest.approx(sorted(ranks.values()))
        assert (group["problems"] == 6).all()


def test_the_test_is_exact_for_few_problems():
    # the one better by 1, 2, ..., 5 hundredths, and worse by 6: all signs are equally likely
    differences = np.array([1, 2, 3, 4, 5, -6]) / 100
    given = {
        str(k): results({("one", 1): [0.5 + d], ("two", 1): [0.5], ("three", 1): [0.1]})
        for k, d in enumerate(differences)
    }
    found = pooled(given).set_index("algorithm")
    sums = [np.dot(signs, range(1, 7)) for signs in product((0, 1), repeat=6)]
    p = 2 * np.mean([s <= 6 for s in sums])
    q = 2 * np.mean([s <= 0 for s in sums])
    assert found.loc["two", "p_holm"] == pytest.approx(max(p, 2 * q))
    assert found.loc["three", "p_holm"] == pytest.approx(2 * q)
    assert found.loc["two", "share_control_better"] == pytest.approx(5 / 6)
    assert np.isnan(found.loc["one", "p_holm"])


@pytest.mark.parametrize("control", NAMES)
def test_a_control_is_tested_against_each_other_one(control):
    given = many(np.random.default_rng(4), 8)
    best, found = pooled(given), pooled(given, control=control)
    tested = ["share_control_better", "n_functions_control_better", "p_holm"]
    pd.testing.assert_frame_equal(found.drop(columns=tested), best.drop(columns=tested))
    for evaluations, group in found.groupby("evaluations"):
        rows = group.set_index("algorithm")
        assert rows.index[rows["p_holm"].isna()].tolist() == [control]
        tables = [each.table[each.table["evaluations"] == evaluations] for each in given.values()]
        medians = pd.DataFrame(t.groupby("algorithm")["hypervolume"].median() for t in tables)
        rivals = [name for name in NAMES if name != control]
        p = {n: stats.wilcoxon(medians[control], medians[n]).pvalue for n in rivals}
        larger = max(p, key=p.get)
        smaller = min(p, key=p.get)
        assert rows.loc[smaller, "p_holm"] == pytest.approx(min(1.0, 2 * p[smaller]))
        assert rows.loc[larger, "p_holm"] == pytest.approx(max(p[larger], min(1.0, 2 * p[smaller])))
        for name in rivals:
            share = (medians[control] > medians[name]).mean()
            assert rows.loc[name, "share_control_better"] == pytest.approx(share)
            assert (
                rows.loc[name, "n_functions_control_better"] == share * rows.loc[name, "functions"]
            )


def copied(given, times):
    """Every problem so many times, as instances of one function."""
    return {
        f"{label} i{i}": SimpleNamespace(
            **vars(each) | {"problem": SimpleNamespace(n_var=4, function_name=label)}
        )
        for label, each in given.items()
        for i in range(times)
    }


def test_instances_of_a_function_do_not_count_twice():
    given = many(np.random.default_rng(6), 9)
    once, often = pooled(given), pooled(copied(given, 5))
    assert (often["problems"] == 45).all()
    pd.testing.assert_frame_equal(often.drop(columns="problems"), once.drop(columns="problems"))
    whole, more = (
        compute_friedman_test(compute_problem_values(g)) for g in (given, copied(given, 5))
    )
    assert (more.statistic, more.n_blocks) == (pytest.approx(whole.statistic), 9)
    assert (more.n_problems, more.critical_difference) == (45, whole.critical_difference)
    pd.testing.assert_series_equal(more.ranks, whole.ranks)


def test_signed_ranks_are_averaged_over_the_instances_of_a_function():
    # |differences| 1 to 8: signed ranks (-1, 2), (3, 4), (5, -6), (7, 8); their means are below
    differences = {"p": (-1, 2), "q": (3, 4), "r": (5, -6), "s": (7, 8)}
    given = {
        f"{function} i{i}": results(
            {("one", 1): [0.5 + d / 100], ("two", 1): [0.5], ("three", 1): [0.1]},
            function_name=function,
        )
        for function, each in differences.items()
        for i, d in enumerate(each)
    }
    found = pooled(given, control="one").set_index("algorithm")
    p = {"two": stats.wilcoxon([0.5, 3.5, -0.5, 7.5]).pvalue, "three": 2 / 2**4}
    assert found.loc["two", "p_holm"] == pytest.approx(max(p["two"], 2 * p["three"]))
    assert found.loc["three", "p_holm"] == pytest.approx(2 * p["three"])
    assert found.loc["two", ["share_control_better", "n_functions_control_better"]].tolist() == [
        6 / 8,
        2 + 2 * 0.5,
    ]
    assert found.loc["one", "average_rank"] == pytest.approx(1 + 2 / 8)
    assert (found["functions"] == 4).all()


def test_fronts_without_a_hypervolume_are_ranked_by_epsilon():
    nothing = {(name, 1): [0.0] for name in NAMES}
    epsilon = {("one", 1): [3.0], ("two", 1): [2.0], ("three", 1): [np.inf]}
    found = pooled({"p": results(nothing, epsilon=epsilon)})
    assert found["algorithm"].tolist() == ["two", "one", "three"]
    some = {**nothing, ("three", 1): [1e-9]}
    assert pooled({"p": results(some, epsilon=epsilon)})["algorithm"].iloc[0] == "three"


def test_problems_are_grouped_by_their_variables_and_counted_per_variable():
    rng = np.random.default_rng(2)
    given = many(rng, 3) | {f"large {k}": v for k, v in many(rng, 2, n_var=8).items()}
    found = pooled(given, per_variable=True)
    counted = found.groupby(["variables", "evaluations"])["problems"].first().to_dict()
    assert counted == {(0, 10): 5, (0, 20): 5, (4, 10): 3, (4, 20): 3, (8, 10): 2, (8, 20): 2}


def test_an_algorithm_whose_runs_all_failed_is_last_there():
    given = many(np.random.default_rng(3), 5)
    whole = compute_problem_values(given)
    given["0"].table = given["0"].table.query("algorithm != 'two'")
    values = compute_problem_values(given)
    assert values.query("problem == '0'")["two"].tolist() == [-np.inf, -np.inf]
    expected = whole.assign(two=whole["two"].where(whole["problem"] != "0", -1.0))
    pd.testing.assert_frame_equal(compute_average_ranks(values), compute_average_ranks(expected))
    found = compute_friedman_test(values)
    assert (len(found.ranks), found.n_blocks) == (3, 5)


def plainly(values, n_var, best):
    found = {}
    for (algorithm, _), trace in values.items():
        for shortfall in TARGET_DISTANCES:
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
    found, expected = compute_runtimes({"p": results(values)}), plainly(values, 4, best)
    assert found.keys() == expected.keys()
    for name, times in expected.items():
        assert np.array_equal(found[name], times)


def test_problems_are_pooled_by_evaluations_per_variable():
    values = {("a", 1): [0.0, 1.0]}
    found = compute_runtimes({"p": results(values, n_var=4), "q": results(values, n_var=8)})["a"]
    assert found.tolist() == [20.0] * 2 * len(TARGET_DISTANCES)


def test_a_run_that_failed_or_found_nothing_reaches_no_target():
    values = {("a", 1): [0.5, 1.0], ("b", 1): [0.0, 0.0]}
    made = results(values, runs=[("a", 1), ("a", 2), ("b", 1), ("c", 1)])
    found = compute_runtimes({"p": made})
    assert np.isfinite(found["a"]).sum() == len(TARGET_DISTANCES)
    assert len(found["a"]) == 2 * len(TARGET_DISTANCES)
    assert np.isinf(found["b"]).all()
    assert np.isinf(found["c"]).all()


def test_nobody_reaches_a_target_where_nobody_reached_anything():
    nothing = results({("a", 1): [0.0, 0.0], ("b", 1): [0.0, 0.0]})
    assert compute_runtime_distribution({"p": nothing})["share"].tolist() == [0.0, 0.0]
    both = compute_runtime_distribution(
        {"p": nothing, "q": results({("a", 1): [0.0, 1.0], ("b", 1): [0, 0]})}
    )
    assert both["share"].tolist() == [0.5, 0.0]


def test_there_are_no_targets_without_a_hypervolume():
    made = results({("a", 1): [1.0]}, indicator=BEST_VALUE)
    assert compute_runtimes({"p": made}) == {}
    assert compute_runtime_distribution({"p": made}).empty
