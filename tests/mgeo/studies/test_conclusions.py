from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from mgeo.studies.conclusions import compare_with_rivals, format_conclusions, format_control_table

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
    sentences = format_conclusions(result)
    assert " ranks first: " in sentences[0]
    assert sentences[1].startswith(
        "steady is significantly better than third 0 (A = 1.00), third 1 (A = 1.00), third 2 "
        "(A = 1.00); significantly worse than risky (A = 0.20). "
    )
    single = result.table.query("algorithm == 'risky'")
    assert format_conclusions(replace(result, table=single)) == []


def test_conclusions_report_parts_where_best_algorithm_is_worse():
    steps = np.arange(8) / 1000
    result = build_final_comparison({"A": 0.60 + steps, "B": 0.55 + steps, "C": 0.50 + steps})
    result = replace(result, space=replace(result.space, parts=(3.0,), cuts=(0.5,)))
    total = result.table["hypervolume"]
    first_part = 0.2 + 0.1 * (result.table["algorithm"] == "B") + total / 100
    result.table["hypervolume_1"], result.table["hypervolume_2"] = first_part, total - first_part
    assert format_conclusions(result)[4:] == [
        "By hypervolume, f1 to 3, A is significantly worse than B (A = 0.00)."
    ]
    parts_table = format_control_table(result, "A", result.part_indicators)
    assert parts_table.loc["B", "hypervolume, f1 to 3: A"] == "0.000"
    assert parts_table.loc["B", "hypervolume, f1 from 3: A"] == "1.000"


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
