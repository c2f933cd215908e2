"""Statistical tests and effect sizes for differences between algorithms."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
import pandas as pd
import scipy  # Imports the slow scipy.stats only at first use.
from numpy.typing import ArrayLike

from mgeo._typing import FloatArray

#: Significance level of all tests.
SIGNIFICANCE_LEVEL = 0.05

# Lower bounds of A for each magnitude (Vargha & Delaney 2000).
_MAGNITUDES = ((0.71, "large"), (0.64, "medium"), (0.56, "small"))


@dataclass(frozen=True, eq=False)
class KruskalWallisResult:
    """Result of the Kruskal-Wallis test for a difference between independent samples.

    Attributes
    ----------
    statistic : float
        Chi-square with k - 1 degrees of freedom for k samples, corrected for ties.
    p_value : float
        p value of the statistic.
    ranks : Series
        Mean rank of each sample, see `mean_ranks`.
    """

    statistic: float
    p_value: float
    ranks: pd.Series[float]


@dataclass(frozen=True, eq=False)
class FriedmanResult:
    """Result of Friedman's test for a difference between algorithms over several problems.

    The values of a block must be related, as the values of all algorithms on one problem are. Runs
    of equal seeds are not related, because runs are independent. Instances of one function form one
    block. Rank 1 is the best.

    Attributes
    ----------
    statistic : float
        Chi-square with k - 1 degrees of freedom for k algorithms, corrected for ties.
    p_value : float
        p value of the statistic.
    ranks : Series
        Average rank of each algorithm, best first.
    n_problems, n_blocks : int
        Number of problems and of blocks.
    critical_difference : float
        Critical difference of average ranks at 5 %, for all pairs (Nemenyi's test, Demsar 2006).
    """

    statistic: float
    p_value: float
    ranks: pd.Series[float]
    n_problems: int
    n_blocks: int
    critical_difference: float


def mann_whitney_p_value(a: ArrayLike, b: ArrayLike) -> float:
    """Return the two-sided p value of the Mann-Whitney test for two independent samples.

    The p value is exact for small samples without ties, and otherwise from the normal approximation
    with a correction for ties. It is 1 if all values are equal, for which scipy 1.18 returns NaN.
    """
    values = np.concatenate([np.asarray(a, dtype=float), np.asarray(b, dtype=float)])
    if len(values) and (values == values[0]).all():
        return 1.0
    return float(scipy.stats.mannwhitneyu(a, b, alternative="two-sided").pvalue)


def holm_correction(p_values: ArrayLike) -> FloatArray:
    """Correct p values for multiple testing by Holm's procedure."""
    values = np.asarray(p_values, dtype=float)
    order = np.argsort(values, kind="stable")
    corrected = np.maximum.accumulate(values[order] * np.arange(len(values), 0, -1))
    return np.minimum(corrected, 1.0)[np.argsort(order)]


def vargha_delaney_effect_size(a: ArrayLike, b: ArrayLike) -> float:
    """Return the Vargha-Delaney effect size A, the probability that `a` exceeds `b`.

    Ties count half.
    """
    x, y = np.asarray(a, dtype=float)[:, None], np.asarray(b, dtype=float)[None, :]
    return float(np.mean((x > y) + 0.5 * (x == y)))


def classify_effect_size(effect_size: float) -> str:
    """Classify an effect size A as negligible, small, medium or large.

    The thresholds are those of Vargha and Delaney (2000).
    """
    return next(
        (text for low, text in _MAGNITUDES if max(effect_size, 1.0 - effect_size) >= low),
        "negligible",
    )


def compare_pairwise(samples: Mapping[str, Sequence[float] | FloatArray]) -> pd.DataFrame:
    """Compare all pairs of samples with the Mann-Whitney test.

    Larger values are better.

    Parameters
    ----------
    samples : mapping of str to array_like
        Values of the runs by algorithm.

    Returns
    -------
    DataFrame
        Names ``a`` and ``b``; ``A``, the probability that a run of a beats a run of b; its
        ``magnitude``; ``p`` of the Mann-Whitney test; and ``p_holm``, corrected for all pairs by
        Holm's procedure.
    """
    table = pd.DataFrame(combinations(samples, 2), columns=["a", "b"])
    pairs = [(samples[a], samples[b]) for a, b in combinations(samples, 2)]
    table["A"] = [vargha_delaney_effect_size(*pair) for pair in pairs]
    table["magnitude"] = [classify_effect_size(effect) for effect in table["A"]]
    table["p"] = [mann_whitney_p_value(*pair) for pair in pairs]
    return table.assign(p_holm=holm_correction(table["p"]))


def mean_ranks(samples: Mapping[str, Sequence[float] | FloatArray]) -> pd.Series[float]:
    """Rank the values of all samples together, and return the mean rank of each sample.

    The sample with the best mean rank comes first. The largest value has rank 1; equal values share
    the mean of their ranks. For two samples, the one with the better mean rank has a
    `vargha_delaney_effect_size` above one half.

    Parameters
    ----------
    samples : mapping of str to array_like
        Values of the runs by algorithm.

    Returns
    -------
    Series
        Mean rank by algorithm.
    """
    names = np.repeat(list(samples), [len(values) for values in samples.values()])
    values = np.concatenate([np.empty(0), *samples.values()])
    ranks = pd.Series(scipy.stats.rankdata(-values), index=names, name="mean rank")
    return ranks.groupby(level=0, sort=False).mean().sort_values(kind="stable")


def kruskal_wallis_test(samples: Mapping[str, Sequence[float] | FloatArray]) -> KruskalWallisResult:
    """Apply the Kruskal-Wallis test for a difference between independent samples.

    Larger values are better.

    Parameters
    ----------
    samples : mapping of str to array_like
        Values of the runs by algorithm.

    Returns
    -------
    KruskalWallisResult

    Raises
    ------
    ValueError
        If there are fewer than two samples, or a sample is empty.
    """
    sizes = {name: len(values) for name, values in samples.items()}
    if len(sizes) < 2 or 0 in sizes.values():
        raise ValueError(f"samples of sizes {sizes}: expected two or more, none of them empty")
    ranks = mean_ranks(samples)
    if np.unique(np.concatenate(list(samples.values()))).size == 1:
        return KruskalWallisResult(0.0, 1.0, ranks)
    result = scipy.stats.kruskal(*samples.values())
    return KruskalWallisResult(float(result.statistic), float(result.pvalue), ranks)


def mean_block_ranks(values: ArrayLike, blocks: ArrayLike) -> FloatArray:
    """Rank the algorithms on each problem, and average the ranks over related problems.

    A block is a group of related problems.

    Parameters
    ----------
    values : array_like, shape (n_problems, n_algorithms)
        Values, of which the largest on a problem has rank 1.
    blocks : array_like, shape (n_problems,)
        Block of each problem.

    Returns
    -------
    array, shape (n_blocks, n_algorithms)
        Average ranks.
    """
    ranks = pd.DataFrame(scipy.stats.rankdata(-np.asarray(values, dtype=float), axis=1))
    return ranks.groupby(np.asarray(blocks)).mean().to_numpy()


def friedman_test(
    values: ArrayLike, names: Sequence[str], blocks: Sequence[str] | None = None
) -> FriedmanResult:
    """Apply Friedman's test for differences between algorithms over several problems.

    Larger values are better.

    Parameters
    ----------
    values : array_like, shape (n_problems, n_algorithms)
        Values.
    names : sequence of str
        Labels of the algorithms.
    blocks : sequence of str, optional
        Block of each problem, over which ranks are averaged. By default, each problem is a block.
        Averaged ranks vary less than ranks, so the critical difference is conservative.

    Returns
    -------
    FriedmanResult

    Raises
    ------
    ValueError
        If there are fewer than two algorithms or two blocks.
    """
    table = np.asarray(values, dtype=float)
    block_names = np.arange(len(table)) if blocks is None else np.asarray(blocks)
    if (
        table.ndim != 2
        or table.shape[1] != len(names)
        or min(len(set(block_names)), len(names)) < 2
    ):
        raise ValueError(
            f"values of shape {table.shape} for {len(names)} algorithms: expected (problems, "
            "algorithms), two or more of each, and two blocks or more"
        )
    ranks = mean_block_ranks(table, block_names)
    n, k = ranks.shape
    mean = pd.Series(ranks.mean(axis=0), index=list(names), name="average rank")
    # scipy's test requires three algorithms and ranks of single problems. Ties and averages reduce
    # the sum of squared ranks, so dividing by this sum corrects for both.
    spread = np.sum((ranks - (k + 1) / 2) ** 2) / (n * (k - 1))
    statistic = float(n * np.sum((mean - (k + 1) / 2) ** 2) / spread) if spread > 0 else 0.0
    p = float(scipy.stats.chi2.sf(statistic, k - 1))
    ordered = mean.sort_values(kind="stable")
    return FriedmanResult(statistic, p, ordered, len(table), n, nemenyi_critical_difference(k, n))


def nemenyi_critical_difference(
    n_algorithms: int, n_blocks: int, alpha: float = SIGNIFICANCE_LEVEL
) -> float:
    """Return the smallest difference in average rank that Nemenyi's test finds significant.

    Parameters
    ----------
    n_algorithms, n_blocks : int
        Numbers of algorithms and of blocks.
    alpha : float
        Significance level.
    """
    q = scipy.stats.studentized_range.ppf(1.0 - alpha, n_algorithms, np.inf) / np.sqrt(2.0)
    return float(q * np.sqrt(n_algorithms * (n_algorithms + 1) / (6.0 * n_blocks)))


def bootstrap_band(
    samples: FloatArray, level: float = 0.95, n_resamples: int = 2000, seed: int = 0
) -> tuple[FloatArray, FloatArray]:
    """Return the bounds of a bootstrap confidence band for the mean curve.

    Whole runs are resampled, so that the band applies to whole curves. The bounds are percentiles.

    Parameters
    ----------
    samples : array, shape (n_runs, n_points)
        Curve of each run.
    level : float
        Confidence level.
    n_resamples : int
        Number of bootstrap samples.
    seed : int
        Seed of the random generator.

    Returns
    -------
    low, high : array, shape (n_points,)
        Bounds of the interval.
    """
    runs = len(samples)
    resampled = np.random.default_rng(seed).integers(0, runs, (n_resamples, runs))
    weights = np.stack([np.bincount(row, minlength=runs) for row in resampled]) / runs
    tail = (1.0 - level) / 2.0
    low, high = np.quantile(weights @ samples, [tail, 1.0 - tail], axis=0)
    return low, high
