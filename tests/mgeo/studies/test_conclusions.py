"""Sentences and small tables about a comparison."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from mgeo.studies.comparison import Comparison
from mgeo.studies.conclusions import against, conclusions, control_table

from .samples import VALUES, comparison


def test_the_conclusions_name_the_best_its_rivals_and_what_points_say():
    made = comparison()
    made.table.loc[made.table["algorithm"] == "B", "points"] = 99
    assert conclusions(made) == [
        "By hypervolume, A_1 ranks first: 0.60 ± 0.10, then C: 0.45 ± 0.23.",
        "It is not significantly different from any other (A from 0.72 to 1.00). A is the "
        "probability that a run of it beats one of the other; Mann-Whitney test with Holm's "
        "correction for all pairs, 5 %.",
        "By IGD+, A_1 ranks first, too.",
        "By additive epsilon, A_1 ranks first, too.",
        "The most points are on the fronts of B: 99 on average. By hypervolume it is number 3 of "
        "3: points say how finely a front was traced, not how far it reaches.",
    ]


def test_the_conclusions_part_rivals_from_others():
    made = comparison()
    spread = {"A_1": 0.7, "B": 0.1, "C": 0.69}
    rows = [
        {"algorithm": name, "seed": seed, "evaluations": 100, "points": 9, "hypervolume": v}
        for name, value in spread.items()
        for seed, v in enumerate(value + 0.01 * np.arange(8), 1)
    ]
    table = pd.DataFrame(rows).assign(igd_plus=0.5, epsilon=0.5)
    found = conclusions(Comparison(**{**vars(made), "table": table}))
    assert found[1].startswith(
        "It is not significantly different from C (A = 0.62); it is significantly better than all "
        "others (A = 1.00). "
    )
    table = table.query("algorithm != 'C'")
    two = Comparison(**{**vars(made), "table": table, "algorithms": ("A_1", "B")})
    assert conclusions(two)[1].startswith(
        "It is significantly better than every other (A = 1.00). "
    )
    one = Comparison(**{**vars(made), "table": table.query("algorithm == 'B'")})
    assert conclusions(one) == []


def final(values, points=9):
    """A comparison of hypervolumes only, by algorithm; 0 is a run without a front."""
    rows = [
        {"algorithm": name, "seed": seed, "evaluations": 100, "hypervolume": v}
        | {"igd_plus": 1 - v if v else np.inf, "epsilon": 1 - v if v else np.inf}
        | {"points": points if v else 0}
        for name, column in values.items()
        for seed, v in enumerate(column, 1)
    ]
    table = pd.DataFrame(rows)
    return Comparison(**{**vars(comparison()), "table": table, "algorithms": tuple(values)})


def test_the_conclusions_correct_for_the_rivals_of_a_control_alone():
    # of A and B p = 60 / 3432, the least of three pairs: twice is below 5 %, three times is not
    steps = np.arange(7) / 100
    made = final({"A": 0.535 + steps, "B": 0.5 + steps, "C": 0.5175 + steps})
    p = made.tests().pairs.set_index(["a", "b"])["p"]
    assert p["A", "B"] == pytest.approx(60 / 3432)
    assert "It is not significantly different from any other" in conclusions(made)[1]
    found = conclusions(made, "A")
    assert found[1].startswith(
        "It is not significantly different from C (A = 0.69); it is significantly better than all "
        "others (A = 0.88). "
    )
    assert "correction for its rivals, 5 %" in found[1]
    assert conclusions(made, "B") == conclusions(made)  # the first was not named before
    # by another indicator, B is ahead of the control
    swapped = made.table["algorithm"].replace({"A": "B", "B": "A"})
    turned = made.table.assign(algorithm=swapped).sort_values(["algorithm", "seed"])
    made.table["igd_plus"] = turned["igd_plus"].to_numpy()
    assert conclusions(made)[2].endswith("these two are not significantly different.")
    assert conclusions(made, "A")[2].endswith("B is significantly better (A = 0.88).")


def test_the_conclusions_say_in_which_part_another_one_is_ahead():
    steps = np.arange(8) / 1000
    made = final({"A": 0.60 + steps, "B": 0.55 + steps, "C": 0.50 + steps})
    assert not any("part of the front" in text for text in conclusions(made))  # not measured
    made = replace(made, space=replace(made.space, parts=(3.0,), cuts=(0.5,)))
    total = made.table["hypervolume"]
    ahead = 0.2 + 0.1 * (made.table["algorithm"] == "B") + total / 100
    made.table["hypervolume_1"], made.table["hypervolume_2"] = ahead, total - ahead
    assert "hypervolume, f1 to 3" in made.overview()
    assert (
        "In a part of the front are significantly better than A: B by hypervolume, f1 to 3."
        in conclusions(made)
    )
    of_parts = control_table(made, "A", made.parts)
    assert of_parts.loc["B", "hypervolume, f1 to 3: A"] == "0.000"
    assert of_parts.loc["B", "hypervolume, f1 from 3: A"] == "1.000"
    made.table["hypervolume_1"], made.table["hypervolume_2"] = 0.1, total - 0.1
    assert "In no part of the front is another one significantly better than A." in conclusions(
        made
    )


def test_a_front_in_one_run_of_ten_is_not_the_best():
    made = final({"always": 0.50 + 0.001 * np.arange(10), "once": [0.0] * 9 + [0.9]})
    for indicator in (None, "igd_plus", "epsilon"):
        assert made.order(indicator) == ["always", "once"]
    found = conclusions(made)
    assert (
        found[0] == "By hypervolume, always ranks first: 0.5045 ± 0.0030, then once: 0.09 ± 0.28."
    )
    assert found[1].startswith("It is significantly better than every other (A = 0.90). ")
    assert found[2:4] == [
        f"By {name}, always ranks first, too." for name in ("IGD+", "additive epsilon")
    ]
    assert made.overview().loc["once", "IGD+"] == "inf"
    assert made.to_latex().count(r"\textbf") == 3 + len(made.parts)
    assert r"always & 10 & \textbf{0.5045" in made.to_latex()


def test_conclusions_name_what_beats_the_first():
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
    assert made.order()[:2] == ["steady", "risky"]
    found = conclusions(made)
    assert " ranks first: " in found[0]
    assert found[1].startswith(
        "It is significantly better than all others (A = 1.00); it is significantly worse than "
        "risky (A = 0.20). "
    )


def test_a_control_is_corrected_for_its_rivals_alone():
    made = comparison()
    rows = against(made, "B", control=True)
    assert list(rows.index) == ["A_1", "C"]
    # of three and three values, all apart, 2 of 20 orders: for two rivals, not for three pairs
    tied = stats.mannwhitneyu(VALUES["B"], VALUES["C"]).pvalue
    assert tied > 0.2
    assert rows["p_holm"].tolist() == pytest.approx([2 * 0.1, tied])
    assert against(made, "B")["p_holm"].tolist() == pytest.approx([3 * 0.1, 2 * tied])
    table = control_table(made, "B", made.indicators)
    assert table["hypervolume: A"].tolist() == ["0.000", f"{1.5 / 9:.3f}"]
    assert table["IGD+: p (Holm)"].tolist() == ["0.2", f"{tied:.2g}"]
    assert table.index.name == "B against"
