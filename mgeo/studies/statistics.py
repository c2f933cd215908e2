"""Tests of whether algorithms differ, and by how much."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
import pandas as pd
import scipy  # its `stats` takes long to import, and only when it is used
from numpy.typing import ArrayLike

from mgeo._typing import FloatArray

#: Of significance: a difference is called significant where p is below it.
LEVEL = 0.05

# Vargha & Delaney (2000): A of at least so much is called that.
_MAGNITUDES = ((0.71, "large"), (0.64, "medium"), (0.56, "small"))


@dataclass(frozen=True, eq=False)
class KruskalWallis:
    """Kruskal and Wallis' test (1952) of independent samples: whether any of them differ.

    Attributes
    ----------
    statistic, p : chi-square with k - 1 degrees of freedom, corrected for ties.
    ranks : see `mean_ranks`.
    """

    statistic: float
    p: float
    ranks: pd.Series[float]


@dataclass(frozen=True, eq=False)
class Friedman:
    """Friedman's test over problems, with ranks; 1 is the best.

    Values of a block must belong together: those of one problem do, those of one seed do not,
    because every run is independent of every other. Problems that belong together, as instances
    of one function do, are one block.

    Attributes
    ----------
    statistic, p : chi-square with k - 1 degrees of freedom, corrected for ties.
    ranks : average rank of each algorithm, best first.
    problems, blocks : how many.
    critical_difference : of average ranks, at 5 %: Nemenyi's test for all pairs (Demsar 2006).
    """

    statistic: float
    p: float
    ranks: pd.Series[float]
    problems: int
    blocks: int
    critical_difference: float


def mann_whitney(a: ArrayLike, b: ArrayLike) -> float:
    """Two-sided p value that two independent samples come from one distribution.

    Exact for small samples without ties, or else the normal approximation corrected for ties. 1 if
    all values are the same: of ranks that do not vary scipy 1.18 gives NaN.
    """
    values = np.concatenate([np.asarray(a, dtype=float), np.asarray(b, dtype=float)])
    if len(values) and (values == values[0]).all():
        return 1.0
    return float(scipy.stats.mannwhitneyu(a, b, alternative="two-sided").pvalue)


def holm(p: ArrayLike) -> FloatArray:
    """p values corrected for their number by Holm's step-down procedure."""
    values = np.asarray(p, dtype=float)
    order = np.argsort(values, kind="stable")
    corrected = np.maximum.accumulate(values[order] * np.arange(len(values), 0, -1))
    return np.minimum(corrected, 1.0)[np.argsort(order)]


def vargha_delaney(a: ArrayLike, b: ArrayLike) -> float:
    """A: probability that a value of `a` is larger than one of `b`, ties counting half."""
    x, y = np.asarray(a, dtype=float)[:, None], np.asarray(b, dtype=float)[None, :]
    return float(np.mean((x > y) + 0.5 * (x == y)))


def magnitude(effect: float) -> str:
    """Vargha and Delaney's word for an A: negligible, small, medium or large."""
    return next((w for least, w in _MAGNITUDES if max(effect, 1.0 - effect) >= least), "negligible")


def pairwise(samples: Mapping[str, Sequence[float] | FloatArray]) -> pd.DataFrame:
    """All pairs of samples, larger values being better.

    Columns: ``a``, ``b``; ``A``, the probability that a run of a beats one of b, with its
    ``magnitude``; ``p`` of the Mann-Whitney test and ``p_holm``, corrected for all pairs.
    """
    table = pd.DataFrame(combinations(samples, 2), columns=["a", "b"])
    pairs = [(samples[a], samples[b]) for a, b in combinations(samples, 2)]
    table["A"] = [vargha_delaney(*pair) for pair in pairs]
    table["magnitude"] = [magnitude(effect) for effect in table["A"]]
    table["p"] = [mann_whitney(*pair) for pair in pairs]
    return table.assign(p_holm=holm(table["p"]))


def mean_ranks(samples: Mapping[str, Sequence[float] | FloatArray]) -> pd.Series[float]:
    """Mean rank of each sample's values among those of all samples, the best first.

    Rank 1 has the largest value; equal values share the mean of their ranks. Of two samples the
    one with the better mean rank is the one of which `vargha_delaney` is above one half.
    """
    names = np.repeat(list(samples), [len(values) for values in samples.values()])
    values = np.concatenate([np.empty(0), *samples.values()])
    ranks = pd.Series(scipy.stats.rankdata(-values), index=names, name="mean rank")
    return ranks.groupby(level=0, sort=False).mean().sort_values(kind="stable")


def kruskal_wallis(samples: Mapping[str, Sequence[float] | FloatArray]) -> KruskalWallis:
    """Kruskal and Wallis' test of independent samples, larger values being better.

    Raises
    ------
    ValueError
        For fewer than two samples, or an empty one.
    """
    sizes = {name: len(values) for name, values in samples.items()}
    if len(sizes) < 2 or 0 in sizes.values():
        raise ValueError(f"samples of sizes {sizes}: expected two or more, none of them empty")
    ranks = mean_ranks(samples)
    if np.unique(np.concatenate(list(samples.values()))).size == 1:
        return KruskalWallis(0.0, 1.0, ranks)
    found = scipy.stats.kruskal(*samples.values())
    return KruskalWallis(float(found.statistic), float(found.pvalue), ranks)


def ranks_of_blocks(values: ArrayLike, blocks: ArrayLike) -> FloatArray:
    """Ranks of values (problems, algorithms) on each problem, the largest 1, averaged over those
    of a block: (blocks, algorithms)."""
    ranks = pd.DataFrame(scipy.stats.rankdata(-np.asarray(values, dtype=float), axis=1))
    return ranks.groupby(np.asarray(blocks)).mean().to_numpy()


def friedman(
    values: ArrayLike, names: Sequence[str], blocks: Sequence[str] | None = None
) -> Friedman:
    """Friedman's test of values (problems, algorithms), larger ones being better.

    Parameters
    ----------
    blocks : of each problem, the name of its block, over which ranks are averaged; None if each
        is one. Means vary less than ranks, so that the critical difference is on the safe side.

    Raises
    ------
    ValueError
        For fewer than two algorithms or two blocks.
    """
    table = np.asarray(values, dtype=float)
    of = np.arange(len(table)) if blocks is None else np.asarray(blocks)
    if table.ndim != 2 or table.shape[1] != len(names) or min(len(set(of)), len(names)) < 2:
        raise ValueError(
            f"values of shape {table.shape} for {len(names)} algorithms: expected (problems, "
            "algorithms), two or more of each, and two blocks or more"
        )
    ranks = ranks_of_blocks(table, of)
    n, k = ranks.shape
    mean = pd.Series(ranks.mean(axis=0), index=list(names), name="average rank")
    # scipy's wants three algorithms or more, and ranks. The sum of squares of all ranks is smaller
    # where there are ties or means, which is the correction.
    spread = np.sum((ranks - (k + 1) / 2) ** 2) / (n * (k - 1))
    statistic = float(n * np.sum((mean - (k + 1) / 2) ** 2) / spread) if spread > 0 else 0.0
    p = float(scipy.stats.chi2.sf(statistic, k - 1))
    ordered = mean.sort_values(kind="stable")
    return Friedman(statistic, p, ordered, len(table), n, critical_difference(k, n))


def critical_difference(k: int, blocks: int, alpha: float = LEVEL) -> float:
    """Nemenyi's critical difference of average ranks of k algorithms over so many problems."""
    q = scipy.stats.studentized_range.ppf(1.0 - alpha, k, np.inf) / np.sqrt(2.0)
    return float(q * np.sqrt(k * (k + 1) / (6.0 * blocks)))


def bootstrap_band(
    samples: FloatArray, level: float = 0.95, resamples: int = 2000, seed: int = 0
) -> tuple[FloatArray, FloatArray]:
    """Percentile bootstrap interval of the mean over runs.

    Parameters
    ----------
    samples : (runs, points); whole runs are drawn again, so the band belongs to whole curves.

    Returns
    -------
    Lower and upper bound, (points,) each.
    """
    runs = len(samples)
    drawn = np.random.default_rng(seed).integers(0, runs, (resamples, runs))
    weights = np.stack([np.bincount(row, minlength=runs) for row in drawn]) / runs
    tail = (1.0 - level) / 2.0
    low, high = np.quantile(weights @ samples, [tail, 1.0 - tail], axis=0)
    return low, high
