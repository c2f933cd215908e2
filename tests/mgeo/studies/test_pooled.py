"""Average ranks and runtimes over problems, compared with direct calculations."""

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


def compute_ranks(comparisons, per_variable=False, control=None):
    return compute_average_ranks(compute_problem_values(comparisons, per_variable), control)


def build_results(
    values, n_var=4, epsilon=None, function_name="", runs=None, indicator=INDICATORS[0]
):
    """Return a comparison with prescribed hypervolumes after 40, 80, ... evaluations."""
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
    runs_frame = pd.DataFrame(runs or list(values), columns=["algorithm", "seed"])
    return SimpleNamespace(
        table=pd.DataFrame(rows),
        runs=runs_frame,
        algorithms=tuple(dict.fromkeys(runs_frame["algorithm"])),
        problem=SimpleNamespace(n_var=n_var, function_name=function_name),
        select_indicator=lambda: indicator,
    )


def build_random_results(rng, n, **options):
    return {
        str(k): build_results(
            {(name, seed): rng.random(2) for name in NAMES for seed in (1, 2, 3)}, **options
        )
        for k in range(n)
    }


def test_average_ranks_equal_direct_calculation():
    comparisons = build_random_results(np.random.default_rng(1), 6)
    ranks = compute_ranks(comparisons)
    assert ranks["evaluations"].unique().tolist() == [40, 80]
    assert set(ranks["variables"]) == {0}
    for evaluations, group in ranks.groupby("evaluations"):
        expected = dict.fromkeys(NAMES, 0.0)
        for each in comparisons.values():
            rows = each.table[each.table["evaluations"] == evaluations]
            medians = {n: rows[rows["algorithm"] == n]["hypervolume"].median() for n in NAMES}
            for place, name in enumerate(sorted(NAMES, key=medians.get, reverse=True)):
                expected[name] += (place + 1) / 6
        assert group["algorithm"].tolist() == sorted(NAMES, key=expected.get)
        assert group["average_rank"].tolist() == pytest.approx(sorted(expected.values()))
        assert (group["problems"] == 6).all()


def test_signed_rank_test_is_exact_for_few_problems():
    # Under the null hypothesis, all 64 combinations of signs are equally likely.
    differences = np.array([1, 2, 3, 4, 5, -6]) / 100
    comparisons = {
        str(k): build_results({("one", 1): [0.5 + d], ("two", 1): [0.5], ("three", 1): [0.1]})
        for k, d in enumerate(differences)
    }
    ranks = compute_ranks(comparisons).set_index("algorithm")
    sums = [np.dot(signs, range(1, 7)) for signs in product((0, 1), repeat=6)]
    p = 2 * np.mean([s <= 6 for s in sums])
    q = 2 * np.mean([s <= 0 for s in sums])
    assert ranks.loc["two", "p_holm"] == pytest.approx(max(p, 2 * q))
    assert ranks.loc["three", "p_holm"] == pytest.approx(2 * q)
    assert ranks.loc["two", "share_control_better"] == pytest.approx(5 / 6)
    assert np.isnan(ranks.loc["one", "p_holm"])


@pytest.mark.parametrize("control", NAMES)
def test_control_is_tested_against_each_other_algorithm(control):
    comparisons = build_random_results(np.random.default_rng(4), 8)
    best, ranks = compute_ranks(comparisons), compute_ranks(comparisons, control=control)
    tested = ["share_control_better", "n_functions_control_better", "p_holm"]
    pd.testing.assert_frame_equal(ranks.drop(columns=tested), best.drop(columns=tested))
    for evaluations, group in ranks.groupby("evaluations"):
        rows = group.set_index("algorithm")
        assert rows.index[rows["p_holm"].isna()].tolist() == [control]
        tables = [
            each.table[each.table["evaluations"] == evaluations] for each in comparisons.values()
        ]
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


def copy_as_instances(comparisons, times):
    """Return copies of each comparison, as instances of one function."""
    return {
        f"{label} i{i}": SimpleNamespace(
            **vars(each) | {"problem": SimpleNamespace(n_var=4, function_name=label)}
        )
        for label, each in comparisons.items()
        for i in range(times)
    }


def test_instances_of_a_function_count_once():
    comparisons = build_random_results(np.random.default_rng(6), 9)
    once, often = compute_ranks(comparisons), compute_ranks(copy_as_instances(comparisons, 5))
    assert (often["problems"] == 45).all()
    pd.testing.assert_frame_equal(often.drop(columns="problems"), once.drop(columns="problems"))
    once_test, often_test = (
        compute_friedman_test(compute_problem_values(g))
        for g in (comparisons, copy_as_instances(comparisons, 5))
    )
    assert (often_test.statistic, often_test.n_blocks) == (pytest.approx(once_test.statistic), 9)
    assert (often_test.n_problems, often_test.critical_difference) == (
        45,
        once_test.critical_difference,
    )
    pd.testing.assert_series_equal(often_test.ranks, once_test.ranks)


def test_signed_ranks_are_averaged_over_instances():
    # The signed ranks are (-1, 2), (3, 4), (5, -6), (7, 8), with the means 0.5, 3.5, -0.5, 7.5.
    differences = {"p": (-1, 2), "q": (3, 4), "r": (5, -6), "s": (7, 8)}
    comparisons = {
        f"{function} i{i}": build_results(
            {("one", 1): [0.5 + d / 100], ("two", 1): [0.5], ("three", 1): [0.1]},
            function_name=function,
        )
        for function, each in differences.items()
        for i, d in enumerate(each)
    }
    ranks = compute_ranks(comparisons, control="one").set_index("algorithm")
    p = {"two": stats.wilcoxon([0.5, 3.5, -0.5, 7.5]).pvalue, "three": 2 / 2**4}
    assert ranks.loc["two", "p_holm"] == pytest.approx(max(p["two"], 2 * p["three"]))
    assert ranks.loc["three", "p_holm"] == pytest.approx(2 * p["three"])
    assert ranks.loc["two", ["share_control_better", "n_functions_control_better"]].tolist() == [
        6 / 8,
        2 + 2 * 0.5,
    ]
    assert ranks.loc["one", "average_rank"] == pytest.approx(1 + 2 / 8)
    assert (ranks["functions"] == 4).all()


def test_fronts_with_zero_hypervolume_are_ranked_by_epsilon():
    empty = {(name, 1): [0.0] for name in NAMES}
    epsilon = {("one", 1): [3.0], ("two", 1): [2.0], ("three", 1): [np.inf]}
    ranks = compute_ranks({"p": build_results(empty, epsilon=epsilon)})
    assert ranks["algorithm"].tolist() == ["two", "one", "three"]
    one_positive = {**empty, ("three", 1): [1e-9]}
    assert (
        compute_ranks({"p": build_results(one_positive, epsilon=epsilon)})["algorithm"].iloc[0]
        == "three"
    )


def test_problems_are_grouped_by_number_of_variables():
    rng = np.random.default_rng(2)
    comparisons = build_random_results(rng, 3) | {
        f"large {k}": v for k, v in build_random_results(rng, 2, n_var=8).items()
    }
    ranks = compute_ranks(comparisons, per_variable=True)
    counted = ranks.groupby(["variables", "evaluations"])["problems"].first().to_dict()
    assert counted == {(0, 10): 5, (0, 20): 5, (4, 10): 3, (4, 20): 3, (8, 10): 2, (8, 20): 2}


def test_algorithm_whose_runs_all_failed_is_ranked_last():
    comparisons = build_random_results(np.random.default_rng(3), 5)
    complete = compute_problem_values(comparisons)
    comparisons["0"].table = comparisons["0"].table.query("algorithm != 'two'")
    values = compute_problem_values(comparisons)
    assert values.query("problem == '0'")["two"].tolist() == [-np.inf, -np.inf]
    expected = complete.assign(two=complete["two"].where(complete["problem"] != "0", -1.0))
    pd.testing.assert_frame_equal(compute_average_ranks(values), compute_average_ranks(expected))
    friedman = compute_friedman_test(values)
    assert (len(friedman.ranks), friedman.n_blocks) == (3, 5)


def compute_runtimes_directly(values, n_var, best):
    runtimes = {}
    for (algorithm, _), trace in values.items():
        for shortfall in TARGET_DISTANCES:
            reached = [40 * (i + 1) for i, v in enumerate(trace) if v >= best - shortfall * best]
            runtimes.setdefault(algorithm, []).append(reached[0] / n_var if reached else math.inf)
    return {name: sorted(times) for name, times in runtimes.items()}


def test_runtimes_equal_direct_calculation():
    rng = np.random.default_rng(0)
    values = {
        (a, seed): np.sort(1.0 - 10.0 ** rng.uniform(-6, 0, 7))
        for a in ("one", "two", "three")
        for seed in (1, 2)
    }
    best = max(trace[-1] for trace in values.values())
    runtimes, expected = (
        compute_runtimes({"p": build_results(values)}),
        compute_runtimes_directly(values, 4, best),
    )
    assert runtimes.keys() == expected.keys()
    for name, times in expected.items():
        assert np.array_equal(runtimes[name], times)


def test_runtimes_are_in_evaluations_per_variable():
    values = {("a", 1): [0.0, 1.0]}
    runtimes = compute_runtimes(
        {"p": build_results(values, n_var=4), "q": build_results(values, n_var=8)}
    )["a"]
    assert runtimes.tolist() == [20.0] * 2 * len(TARGET_DISTANCES)


def test_failed_and_empty_runs_reach_no_target():
    values = {("a", 1): [0.5, 1.0], ("b", 1): [0.0, 0.0]}
    comparison = build_results(values, runs=[("a", 1), ("a", 2), ("b", 1), ("c", 1)])
    runtimes = compute_runtimes({"p": comparison})
    assert np.isfinite(runtimes["a"]).sum() == len(TARGET_DISTANCES)
    assert len(runtimes["a"]) == 2 * len(TARGET_DISTANCES)
    assert np.isinf(runtimes["b"]).all()
    assert np.isinf(runtimes["c"]).all()


def test_zero_best_hypervolume_has_no_reached_targets():
    empty = build_results({("a", 1): [0.0, 0.0], ("b", 1): [0.0, 0.0]})
    assert compute_runtime_distribution({"p": empty})["share"].tolist() == [0.0, 0.0]
    both = compute_runtime_distribution(
        {"p": empty, "q": build_results({("a", 1): [0.0, 1.0], ("b", 1): [0, 0]})}
    )
    assert both["share"].tolist() == [0.5, 0.0]


def test_single_objective_has_no_targets():
    comparison = build_results({("a", 1): [1.0]}, indicator=BEST_VALUE)
    assert compute_runtimes({"p": comparison}) == {}
    assert compute_runtime_distribution({"p": comparison}).empty
