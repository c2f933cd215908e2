import numpy as np
import pytest

from mgeo.studies import Comparison

from .samples import VALUES, build_comparison


@pytest.fixture
def comparison():
    return build_comparison()


def test_summary_has_statistics_of_final_values(comparison):
    summary = comparison.summarize()
    assert summary.index.tolist() == ["A_1", "B", "C"]
    assert summary[("runs", "")].tolist() == [3, 3, 3]
    for name, values in VALUES.items():
        statistics = summary.loc[name, "hypervolume"]
        assert statistics["mean"] == pytest.approx(np.mean(values))
        assert statistics["sd"] == pytest.approx(np.std(values, ddof=1))
        assert statistics["median"] == pytest.approx(np.median(values))
        assert (statistics["min"], statistics["max"]) == (min(values), max(values))


def test_indicators_of_either_direction_give_equal_tests(comparison):
    by_hypervolume, by_distance = (
        comparison.test_differences(),
        comparison.test_differences("igd_plus"),
    )
    assert by_hypervolume.indicator == "hypervolume"
    assert by_hypervolume.pairs["A"].tolist() == pytest.approx([1.0, 6.5 / 9, 1.5 / 9])
    assert by_distance.pairs["A"].tolist() == by_hypervolume.pairs["A"].tolist()
    # Ranks among all values: A 4.5, 3, 1; C 4.5, 2, 7.5; B 9, 7.5, 6.
    ranks = {"A_1": 8.5 / 3, "C": 14 / 3, "B": 22.5 / 3}
    assert by_hypervolume.kruskal_wallis.ranks.to_dict() == pytest.approx(ranks)
    assert by_distance.kruskal_wallis.ranks.equals(by_hypervolume.kruskal_wallis.ranks)
    equal = comparison.test_differences("epsilon")
    assert equal.pairs["p"].tolist() == [1, 1, 1]
    assert equal.kruskal_wallis.p_value == 1


def test_statistical_tests_do_not_depend_on_seeds(comparison):
    """Runs are independent, so equal seeds of two algorithms do not pair their runs."""
    table = comparison.table.copy()
    chosen = table["algorithm"] == "C"
    table.loc[chosen, "seed"] = table.loc[chosen, "seed"].map({1: 3, 2: 1, 3: 2})
    permuted = Comparison(**{**vars(comparison), "table": table})
    for name in ("statistic", "p_value"):
        expected = getattr(comparison.test_differences().kruskal_wallis, name)
        assert getattr(permuted.test_differences().kruskal_wallis, name) == expected
    table = comparison.table.query("not (algorithm == 'C' and seed == 2)")
    reduced = Comparison(**{**vars(comparison), "table": table})
    # Ranks among all values: A 3.5, 2, 1; C 3.5, 6.5; B 8, 6.5, 5.
    assert reduced.test_differences().kruskal_wallis.ranks.to_dict() == {
        "A_1": 6.5 / 3,
        "C": 5,
        "B": 6.5,
    }
    assert reduced.summarize()[("runs", "")].tolist() == [3, 3, 2]


def test_summary_contains_algorithms_without_finished_runs(comparison):
    table = comparison.table.query("algorithm != 'C'")
    reduced = Comparison(**{**vars(comparison), "table": table})
    assert reduced.format_overview().loc["C"].tolist() == ["0", "-", "-", "-", "-"]
    assert list(reduced.test_differences().kruskal_wallis.ranks.index) == ["A_1", "B"]
    single = Comparison(**{**vars(comparison), "table": table.query("algorithm != 'B'")})
    assert single.test_differences().kruskal_wallis is None
    assert "C & 0 & - & - & - & -" in reduced.to_latex()


def test_ranking_and_median_seeds(comparison):
    assert comparison.rank_algorithms() == ["A_1", "C", "B"]
    assert [comparison.find_median_seed(name) for name in VALUES] == [2, 2, 1]
    table = comparison.table.query("algorithm == 'A_1' and seed != 1")
    two = Comparison(**{**vars(comparison), "table": table})
    assert (two.find_median_seed("A_1"), two.find_median_seed("B")) == (3, None)
