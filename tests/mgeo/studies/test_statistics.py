import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from mgeo.studies.statistics import (
    bootstrap_band,
    friedman_test,
    holm_correction,
    kruskal_wallis_test,
    mann_whitney_p_value,
    mean_ranks,
    nemenyi_critical_difference,
    vargha_delaney_effect_size,
)

samples = st.lists(st.integers(0, 5), min_size=2, max_size=12)


def test_mann_whitney_is_exact_for_small_samples():
    # Of the C(10, 5) = 252 arrangements, 2 separate the samples completely.
    assert mann_whitney_p_value([1, 2, 3, 4, 5], [6, 7, 8, 9, 10]) == pytest.approx(2 / 252)
    assert mann_whitney_p_value([1, 3], [2, 4]) == pytest.approx(4 / 6)


def test_mann_whitney_of_constant_samples_is_one():
    assert mann_whitney_p_value([0.0, 0.0], [0.0, 0.0, 0.0]) == 1.0
    assert mann_whitney_p_value([np.inf] * 3, [np.inf] * 3) == 1.0


def test_holm_correction_equals_manual_calculation():
    # Sorted p values 0.005 0.01 0.03 0.04 times 4 3 2 1 are 0.02 0.03 0.06 0.04; the corrected
    # values must not decrease.
    assert holm_correction([0.01, 0.04, 0.03, 0.005]) == pytest.approx([0.03, 0.06, 0.06, 0.02])
    assert holm_correction([0.9, 0.8]).tolist() == [1.0, 1.0]
    assert holm_correction([]).shape == (0,)


@given(samples, samples)
def test_vargha_delaney_equals_counted_pairs_and_mann_whitney_u(a, b):
    counted = sum((x > y) + 0.5 * (x == y) for x in a for y in b) / (len(a) * len(b))
    assert vargha_delaney_effect_size(a, b) == pytest.approx(counted)
    assert vargha_delaney_effect_size(a, b) + vargha_delaney_effect_size(b, a) == pytest.approx(1)
    u = stats.mannwhitneyu(a, b, method="asymptotic").statistic if len({*a, *b}) > 1 else None
    if u is not None:
        assert vargha_delaney_effect_size(a, b) == pytest.approx(u / (len(a) * len(b)))


@given(st.lists(samples, min_size=2, max_size=4))
def test_kruskal_wallis_equals_its_definition(lists):
    named = dict(zip("abcd", lists, strict=False))
    result = kruskal_wallis_test(named)
    everything = np.concatenate([np.asarray(values) for values in lists])
    better = [np.sum(everything > x) + (1 + np.sum(everything == x)) / 2 for x in everything]
    parts = np.split(np.array(better), np.cumsum([len(values) for values in lists])[:-1])
    expected = {name: part.mean() for name, part in zip(named, parts, strict=True)}
    assert result.ranks.to_dict() == pytest.approx(expected)
    assert result.ranks.is_monotonic_increasing
    n, spread = len(everything), np.sum((np.array(better) - np.mean(better)) ** 2)
    if spread == 0:
        assert (result.statistic, result.p_value) == (0.0, 1.0)
        return
    between = sum(len(part) * (part.mean() - (n + 1) / 2) ** 2 for part in parts)
    assert result.statistic == pytest.approx((n - 1) * between / spread, abs=1e-9)
    assert result.p_value == pytest.approx(stats.chi2.sf(result.statistic, len(parts) - 1))


@given(samples, samples)
def test_mean_ranks_of_two_samples_determine_effect_size(a, b):
    ranks = mean_ranks({"a": a, "b": b})
    difference = (ranks["b"] - ranks["a"]) / (len(a) + len(b)) + 0.5
    assert vargha_delaney_effect_size(a, b) == pytest.approx(difference)


@pytest.mark.slow
@given(
    st.integers(2, 8).flatmap(
        lambda n: st.lists(
            st.lists(st.integers(0, 4), min_size=4, max_size=4), min_size=n, max_size=n
        )
    )
)
def test_friedman_equals_scipy(rows):
    values = np.array(rows, dtype=float)
    result = friedman_test(values, list("abcd"))
    if (np.ptp(values, axis=1) > 0).any():
        expected = stats.friedmanchisquare(*values.T)
        assert result.statistic == pytest.approx(expected.statistic)
        assert result.p_value == pytest.approx(expected.pvalue)
    else:
        assert (result.statistic, result.p_value) == (0.0, 1.0)
    assert result.ranks.mean() == pytest.approx(2.5)


def test_friedman_equals_manual_calculation():
    # The ranks are 1 2 3, 1 2 3 and 2 1 3, with the sums 4, 5, 9.
    result = friedman_test([[9, 5, 1], [8, 6, 2], [4, 7, 3]], ["p", "q", "r"])
    assert result.ranks.to_dict() == pytest.approx({"p": 4 / 3, "q": 5 / 3, "r": 3.0})
    assert list(result.ranks.index) == ["p", "q", "r"]
    assert result.statistic == pytest.approx(12 / (3 * 3 * 4) * (16 + 25 + 81) - 3 * 3 * 4)
    assert result.n_blocks == 3


def test_friedman_averages_ranks_over_each_block():
    # The ranks 1 2 3 and 2 1 3 of the first block average to 1.5 1.5 3; the second has 1 2 3.
    values, blocks = [[9, 5, 1], [5, 9, 1], [9, 5, 1]], ["x", "x", "y"]
    result = friedman_test(values, ["p", "q", "r"], blocks)
    assert result.ranks.to_dict() == pytest.approx({"p": 1.25, "q": 1.75, "r": 3.0})
    assert (result.n_problems, result.n_blocks) == (3, 2)
    assert result.critical_difference == nemenyi_critical_difference(3, 2)
    # Sum of squares of the average ranks about their mean, divided by the variance in the blocks.
    spread = (0.25 + 0.25 + 1 + 1 + 0 + 1) / (2 * 2)
    assert result.statistic == pytest.approx(2 * (0.75**2 + 0.25**2 + 1) / spread)
    with pytest.raises(ValueError, match="two blocks or more"):
        friedman_test(values, ["p", "q", "r"], ["x", "x", "x"])


@pytest.mark.parametrize("shape", [(1, 3), (3, 1), (3, 2)])
def test_friedman_rejects_too_few_algorithms_or_blocks(shape):
    with pytest.raises(ValueError, match="two or more of each"):
        friedman_test(np.zeros(shape), ["a"] * (shape[1] if shape != (3, 2) else 5))


@pytest.mark.parametrize(("k", "q"), [(2, 1.960), (3, 2.343), (5, 2.728), (10, 3.164)])
def test_critical_difference_equals_published_table(k, q):
    # The values are from Demsar (2006), table 5(a), two-tailed Nemenyi test at 0.05.
    assert nemenyi_critical_difference(k, 14) == pytest.approx(
        q * np.sqrt(k * (k + 1) / 84), rel=3e-4
    )


def test_bootstrap_band_approximates_normal_interval_of_mean():
    runs = np.random.default_rng(3).normal([0.0, 5.0], [1.0, 0.1], (40, 2))
    low, high = bootstrap_band(runs)
    half = 1.96 * runs.std(axis=0) / np.sqrt(40)
    assert low == pytest.approx(runs.mean(axis=0) - half, abs=0.2 * half.max())
    assert high == pytest.approx(runs.mean(axis=0) + half, abs=0.2 * half.max())
    repeated = bootstrap_band(runs)
    assert np.array_equal(low, repeated[0])
    assert np.array_equal(high, repeated[1])
