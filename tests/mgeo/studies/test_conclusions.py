from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from mgeo.studies.conclusions import (
    build_test_table,
    compare_with_rivals,
    format_conclusions,
    format_control_table,
    join_names,
    list_warnings,
    summarize_study,
)
from mgeo.studies.study_file import parse_study
from mgeo.studies.summary_tables import (
    build_behind_table,
    build_budget_table,
    build_rank_table,
    build_result_table,
)

from .samples import VALUES, build_comparison, build_final_comparison


def test_conclusions_group_algorithms_by_significance():
    """An algorithm can rank first although another one wins most pairs against it.

    This happens if some runs of the other algorithm are worse than all other runs.
    """
    offsets = 0.001 * np.arange(20)
    result = build_final_comparison(
        {
            "steady": 0.70 + offsets,
            "risky": [*(0.10 + offsets[:4]), *(0.75 + offsets[:16])],
            **{f"third {i}": 0.60 + offsets for i in range(3)},
        }
    )
    assert result.rank_algorithms()[:2] == ["steady", "risky"]
    rivals = compare_with_rivals(result, "steady")
    assert rivals["result"].to_dict() == {
        "risky": "behind",
        **dict.fromkeys(("third 0", "third 1", "third 2"), "ahead"),
    }
    first, differences, *_ = format_conclusions(result)
    assert first.startswith("steady ranks first")
    better, worse = differences.split(";")
    assert "better than third 0, third 1 and third 2" in better
    assert "worse than risky" in worse
    single = result.table.query("algorithm == 'risky'")
    assert format_conclusions(replace(result, table=single)) == []


def test_conclusions_report_parts_where_best_algorithm_is_worse():
    steps = np.arange(8) / 1000
    result = build_final_comparison({"A": 0.60 + steps, "B": 0.55 + steps, "C": 0.50 + steps})
    result = replace(result, space=replace(result.space, parts=(3.0,), cuts=(0.5,)))
    total = result.table["hypervolume"]
    first_part = 0.2 + 0.1 * (result.table["algorithm"] == "B") + total / 100
    result.table["hypervolume_1"], result.table["hypervolume_2"] = first_part, total - first_part
    (sentence,) = [text for text in format_conclusions(result) if "f1 to 3" in text]
    assert "A is significantly worse than B" in sentence
    assert not any("f1 from 3" in text for text in format_conclusions(result))
    parts_table = format_control_table(result, "A", result.part_indicators)
    assert parts_table.loc["B", "hypervolume, f1 to 3: A"] == "0.000"
    assert parts_table.loc["B", "hypervolume, f1 from 3: A"] == "1.000"


def test_conclusions_say_by_which_further_indicators_the_difference_is_significant():
    steps = np.arange(8) / 1000
    result = build_final_comparison({"A": 0.60 + steps, "B": 0.55 + steps})
    result.table["epsilon"] = 0.1 * (
        result.table["seed"] + 0.1 * (result.table["algorithm"] == "B")
    )
    _, _, significant, insignificant = format_conclusions(result)
    assert "IGD+, significantly better" in significant
    assert "additive epsilon" in insignificant
    assert "significant" not in insignificant


def test_one_good_run_of_ten_does_not_rank_first():
    result = build_final_comparison(
        {"always": 0.50 + 0.001 * np.arange(10), "once": [0.0] * 9 + [0.9]}
    )
    for indicator in (None, "igd_plus", "epsilon"):
        assert result.rank_algorithms(indicator) == ["always", "once"]
    assert result.format_overview().loc["once", "IGD+"] == "inf"
    assert result.to_latex().count(r"\textbf") == 3 + len(result.part_indicators)
    assert r"always & 10 & \textbf{0.5045" in result.to_latex()


def test_p_values_of_control_are_corrected_for_its_pairs_only():
    result = build_comparison()
    rows = compare_with_rivals(result, "B", is_control=True)
    assert list(rows.index) == ["A_1", "C"]
    # Of the 20 orders of two separate samples of three values, 2 are as extreme: p = 0.1. It is
    # multiplied by two for the pairs of the control, and by three for all pairs.
    p_tied = stats.mannwhitneyu(VALUES["B"], VALUES["C"]).pvalue
    assert p_tied > 0.2
    assert rows["p_holm"].tolist() == pytest.approx([2 * 0.1, p_tied])
    assert compare_with_rivals(result, "B")["p_holm"].tolist() == pytest.approx(
        [3 * 0.1, 2 * p_tied]
    )
    table = format_control_table(result, "B", result.indicators)
    assert table["hypervolume: A"].tolist() == ["0.000", f"{1.5 / 9:.3f}"]
    assert table["IGD+: p (Holm)"].tolist() == ["0.2", f"{p_tied:.2g}"]
    assert table.index.name == "B against"
    tests = build_test_table(result, "B").query("indicator == 'hypervolume'")
    own = tests.set_index(["a", "b"])["p_holm_control"]
    assert own["A_1", "B"] == rows["p_holm"]["A_1"]
    assert own["B", "C"] == rows["p_holm"]["C"]
    assert np.isnan(own["A_1", "C"])
    assert "p_holm_control" not in build_test_table(result)


def build_three_problems():
    """Return comparisons in which the control C is best, equal to A, and worse than A."""
    steps = np.arange(8) / 1000
    values = {"A": 0.5 + steps, "C": 0.6 + steps, "B": 0.2 + steps}
    return {
        "one": build_final_comparison(values),
        "two": build_final_comparison(values | {"A": 0.6 + steps}),
        "three": build_final_comparison(values | {"A": 0.7 + steps}),
    }


def test_study_summary_counts_significant_differences_over_problems():
    comparisons = build_three_problems()
    summary = summarize_study(comparisons, "C")
    assert (summary.algorithm, summary.is_control) == ("C", True)
    ranks = summary.ranks
    assert ranks["average_rank"].to_dict() == pytest.approx({"C": 4.5 / 3, "A": 4.5 / 3, "B": 3})
    assert ranks["best_on"].to_dict() == {"C": 2, "A": 2, "B": 0}
    assert ranks.loc["A", ["better", "equal", "worse"]].tolist() == [1, 1, 1]
    assert ranks.loc["B", ["better", "equal", "worse"]].tolist() == [0, 0, 3]
    assert "C has the largest median hypervolume on 2 of 3 problems" in summary.conclusions[0]
    assert any("worse" in text and "three" in text for text in summary.conclusions)
    table = build_rank_table(comparisons, summary).table
    assert table.loc["B"].tolist()[:5] == ["3.00", "0", "0", "0", "3"]
    behind = build_behind_table(summary)
    assert behind.table.reset_index().to_numpy().tolist()[0][:3] == ["three", "A", "0.00"]


def test_conclusions_name_at_most_three_problems_of_significant_differences():
    comparisons = build_three_problems()
    only_one = summarize_study(comparisons, "C").conclusions
    assert any(text.endswith("1 of 3 problems: one.") for text in only_one)
    many = {f"p{i}": comparisons["one"] for i in range(5)}
    assert any("p0, p1, p2 and 2 more" in text for text in summarize_study(many, "C").conclusions)


def test_notes_explain_zero_hypervolume_where_it_occurs():
    steps = np.arange(4) / 1000
    without, zero = (
        build_final_comparison({"A": a, "B": 0.5 + steps}) for a in (steps + 0.1, [0.0] * 4)
    )
    for comparison in (without, zero):
        comparisons = {"one": comparison, "two": comparison}
        notes = [
            build_result_table(comparison).note,
            build_rank_table(comparisons, summarize_study(comparisons)).note,
        ]
        assert ["reference point" in note for note in notes] == [comparison is zero] * 2


def test_note_of_ranks_says_if_no_difference_can_be_significant():
    """With three problems and two rivals, the exact p value is at least 2 * 2 / 2**3."""
    comparisons = build_three_problems()
    summary = summarize_study(comparisons, "C")
    assert summary.ranks["p_holm"].min() >= 0.5
    assert "too few" in build_rank_table(comparisons, summary).note
    many = {f"{name} {i}": c for i in range(3) for name, c in comparisons.items()}
    assert "too few" not in build_rank_table(many, summarize_study(many, "C")).note


@pytest.mark.parametrize(("sizes", "columns"), [([0], 2), ([0, 5, 10], 4)])
def test_table_of_average_ranks_has_few_budgets(sizes, columns):
    keys = [(size, n, name) for size in sizes for n in range(20, 1001, 20) for name in "ba"]
    ranks = pd.DataFrame(keys, columns=["variables", "evaluations", "algorithm"])
    ranks["problems"] = 6
    ranks["average_rank"] = ranks["algorithm"].map({"a": 2.0, "b": 1.0})
    ranks["p_holm"] = ranks["algorithm"].map({"a": 0.2, "b": np.nan})
    text = 'title = ""\nevaluations = 1000\nseeds = 1\nproblems = [{name = "pymoo:zdt1"}]\n'
    study = parse_study(f'{text}algorithms = [{{name = "nsga2"}}]', Path())
    table = build_budget_table(ranks, study).table.reset_index()
    assert table.shape == (5 * len(sizes), 1 + columns)
    assert table["evaluations"].iloc[-1] == "1,000"
    assert list(table.columns[-2:]) == ["b", "a"]
    assert set(table["a"]) == {"2.00*"}


def test_study_without_control_is_summarized_for_the_best_algorithm():
    comparisons = build_three_problems()
    del comparisons["three"]
    summary = summarize_study(comparisons)
    assert (summary.algorithm, summary.is_control) == ("C", False)
    assert build_behind_table(summary) is None
    one = comparisons["one"]
    only = {"one": replace(one, table=one.table.query("algorithm == 'B'"))}
    assert summarize_study(only) is None


def test_equal_notes_of_several_problems_are_listed_once():
    runs = build_comparison().table[["algorithm", "seed"]].assign(status="finished", error="")
    runs.loc[runs.index[0], ["status", "error"]] = "failed", "ValueError: no"
    noted = replace(build_comparison(), runs=runs)
    comparisons = {name: replace(noted, notes=(f"{name}: is noisy",)) for name in ("p", "q")}
    first, *failures, few_seeds = list_warnings(comparisons)
    assert first == "p and q: is noisy"
    assert "3 seeds" in few_seeds
    assert len(failures) == 2
    assert "1 of 6 runs failed" in failures[0]


@pytest.mark.parametrize(
    ("n_seeds", "n_algorithms", "control", "is_warned"),
    [
        (3, 2, None, True),  # The smallest p value is 2 / 20.
        (4, 2, None, False),  # 2 / 70
        (5, 13, "A0", True),  # 12 pairs of the control: 12 * 2 / 252
        (6, 13, "A0", False),
        (6, 13, None, True),  # 78 pairs: 78 * 2 / 924
        (7, 13, None, False),
    ],
)
def test_warning_of_few_seeds_accounts_for_the_number_of_pairs(
    n_seeds, n_algorithms, control, is_warned
):
    values = {f"A{i}": i + np.arange(n_seeds) / 100 for i in range(n_algorithms)}
    comparison = replace(build_final_comparison(values), runs=build_comparison().table.iloc[:0])
    comparison = replace(comparison, runs=comparison.runs.assign(status="", error=""))
    rivals = compare_with_rivals(comparison, "A0", is_control=control is not None)
    assert (rivals["p_holm"].min() >= 0.05) == is_warned
    assert bool(list_warnings({"one": comparison}, control)) == is_warned


def test_result_table_is_sorted_by_rank():
    table = build_result_table(build_comparison()).table
    assert list(table.index) == ["A_1", "C", "B"]
    assert list(table) == ["hypervolume", "IGD+", "additive epsilon"]


def test_long_lists_of_names_are_shortened():
    assert join_names("a") == "a"
    assert join_names("abc") == "a, b and c"
    assert join_names("abcdef", 3) == "a, b, c and 3 more"
