"""Sentences and small tables about a comparison."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from mgeo.studies.conclusions import compare_with_rivals, format_conclusions, format_control_table

from .samples import VALUES, comparison, final


def test_conclusions_sort_the_rivals_of_the_first():
    """Ranks among all runs need not agree with every pair: where some runs fall behind all, the
    others may be ahead by little, and often.
    """
    few = 0.001 * np.arange(20)
    made = final(
        {
            "steady": 0.70 + few,
            "risky": [*(0.10 + few[:4]), *(0.75 + few[:16])],
            **{f"third {i}": 0.60 + few for i in range(3)},
        }
    )
    assert made.rank_algorithms()[:2] == ["steady", "risky"]
    found = format_conclusions(made)
    assert " ranks first: " in found[0]
    assert found[1].startswith(
        "steady is significantly better than third 0 (A = 1.00), third 1 (A = 1.00), third 2 "
        "(A = 1.00); significantly worse than risky (A = 0.20). "
    )
    alone = made.table.query("algorithm == 'risky'")
    assert format_conclusions(replace(made, table=alone)) == []


def test_conclusions_name_the_parts_in_which_the_first_is_behind():
    steps = np.arange(8) / 1000
    made = final({"A": 0.60 + steps, "B": 0.55 + steps, "C": 0.50 + steps})
    made = replace(made, space=replace(made.space, parts=(3.0,), cuts=(0.5,)))
    total = made.table["hypervolume"]
    ahead = 0.2 + 0.1 * (made.table["algorithm"] == "B") + total / 100
    made.table["hypervolume_1"], made.table["hypervolume_2"] = ahead, total - ahead
    assert format_conclusions(made)[4:] == [
        "By hypervolume, f1 to 3, A is significantly worse than B (A = 0.00)."
    ]
    of_parts = format_control_table(made, "A", made.part_indicators)
    assert of_parts.loc["B", "hypervolume, f1 to 3: A"] == "0.000"
    assert of_parts.loc["B", "hypervolume, f1 from 3: A"] == "1.000"


def test_a_front_in_one_run_of_ten_is_not_the_best():
    made = final({"always": 0.50 + 0.001 * np.arange(10), "once": [0.0] * 9 + [0.9]})
    for indicator in (None, "igd_plus", "epsilon"):
        assert made.rank_algorithms(indicator) == ["always", "once"]
    assert made.format_overview().loc["once", "IGD+"] == "inf"
    assert made.to_latex().count(r"\textbf") == 3 + len(made.part_indicators)
    assert r"always & 10 & \textbf{0.5045" in made.to_latex()


def test_a_control_is_corrected_for_its_rivals_alone():
    made = comparison()
    rows = compare_with_rivals(made, "B", is_control=True)
    assert list(rows.index) == ["A_1", "C"]
    # of three and three values, all apart, 2 of 20 orders: for two rivals, not for three pairs
    tied = stats.mannwhitneyu(VALUES["B"], VALUES["C"]).pvalue
    assert tied > 0.2
    assert rows["p_holm"].tolist() == pytest.approx([2 * 0.1, tied])
    assert compare_with_rivals(made, "B")["p_holm"].tolist() == pytest.approx([3 * 0.1, 2 * tied])
    table = format_control_table(made, "B", made.indicators)
    assert table["hypervolume: A"].tolist() == ["0.000", f"{1.5 / 9:.3f}"]
    assert table["IGD+: p (Holm)"].tolist() == ["0.2", f"{tied:.2g}"]
    assert table.index.name == "B against"
