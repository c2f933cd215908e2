import numpy as np
import pytest

from mgeo.studies import Comparison

from .samples import VALUES
from .samples import comparison as made_by_hand


@pytest.fixture
def comparison():
    return made_by_hand()


def test_the_summary_is_of_the_end_of_the_runs(comparison):
    summary = comparison.summarize()
    assert summary.index.tolist() == ["A_1", "B", "C"]
    assert summary[("runs", "")].tolist() == [3, 3, 3]
    for name, values in VALUES.items():
        found = summary.loc[name, "hypervolume"]
        assert found["mean"] == pytest.approx(np.mean(values))
        assert found["sd"] == pytest.approx(np.std(values, ddof=1))
        assert found["median"] == pytest.approx(np.median(values))
        assert (found["min"], found["max"]) == (min(values), max(values))


def test_a_smaller_distance_wins_as_a_larger_hypervolume_does(comparison):
    volume, distance = comparison.test_differences(), comparison.test_differences("igd_plus")
    assert volume.indicator == "hypervolume"
    assert volume.pairs["A"].tolist() == pytest.approx([1.0, 6.5 / 9, 1.5 / 9])
    assert distance.pairs["A"].tolist() == volume.pairs["A"].tolist()
    # ranks among all: A 4.5, 3, 1; C 4.5, 2, 7.5; B 9, 7.5, 6
    ranks = {"A_1": 8.5 / 3, "C": 14 / 3, "B": 22.5 / 3}
    assert volume.kruskal_wallis.ranks.to_dict() == pytest.approx(ranks)
    assert distance.kruskal_wallis.ranks.equals(volume.kruskal_wallis.ranks)
    same = comparison.test_differences("epsilon")
    assert same.pairs["p"].tolist() == [1, 1, 1]
    assert same.kruskal_wallis.p_value == 1


def test_seeds_are_no_blocks(comparison):
    """Runs are independent: which of them have the same seed must not matter, or be missing."""
    table = comparison.table.copy()
    chosen = table["algorithm"] == "C"
    table.loc[chosen, "seed"] = table.loc[chosen, "seed"].map({1: 3, 2: 1, 3: 2})
    renamed = Comparison(**{**vars(comparison), "table": table})
    for name in ("statistic", "p_value"):
        found = getattr(renamed.test_differences().kruskal_wallis, name)
        assert found == getattr(comparison.test_differences().kruskal_wallis, name)
    table = comparison.table.query("not (algorithm == 'C' and seed == 2)")
    fewer = Comparison(**{**vars(comparison), "table": table})
    # A 3.5, 2, 1; C 3.5, 6.5; B 8, 6.5, 5
    assert fewer.test_differences().kruskal_wallis.ranks.to_dict() == {
        "A_1": 6.5 / 3,
        "C": 5,
        "B": 6.5,
    }
    assert fewer.summarize()[("runs", "")].tolist() == [3, 3, 2]


def test_an_algorithm_without_a_finished_run_stays_in_the_summary(comparison):
    table = comparison.table.query("algorithm != 'C'")
    fewer = Comparison(**{**vars(comparison), "table": table})
    assert fewer.format_overview().loc["C"].tolist() == ["0", "-", "-", "-", "-"]
    assert list(fewer.test_differences().kruskal_wallis.ranks.index) == ["A_1", "B"]
    alone = Comparison(**{**vars(comparison), "table": table.query("algorithm != 'B'")})
    assert alone.test_differences().kruskal_wallis is None
    assert "C & 0 & - & - & - & -" in fewer.to_latex()


def test_the_order_and_the_typical_runs(comparison):
    assert comparison.rank_algorithms() == ["A_1", "C", "B"]
    assert [comparison.find_median_seed(name) for name in VALUES] == [2, 2, 1]
    table = comparison.table.query("algorithm == 'A_1' and seed != 1")
    two = Comparison(**{**vars(comparison), "table": table})
    assert (two.find_median_seed("A_1"), two.find_median_seed("B")) == (3, None)
