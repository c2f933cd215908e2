"""Results over several problems: average ranks, and runtimes to hypervolume targets."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from typing import Any

import numpy as np
import pandas as pd
import scipy  # Imports the slow scipy.stats only at first use.
from numpy.typing import NDArray

from mgeo._typing import FloatArray
from mgeo.plugins.protocol import get_function_name
from mgeo.studies.comparison import Comparison
from mgeo.studies.statistics import FriedmanResult, friedman_test, holm_correction, mean_block_ranks

KEY_COLUMNS = ("problem", "function", "variables", "evaluations")

#: Distances of the targets below the best hypervolume, as shares of it, from 0.79 to 1e-5.
TARGET_DISTANCES = 10.0 ** np.linspace(-0.1, -5.0, 50)


def compute_problem_values(
    comparisons: Mapping[str, Comparison], per_variable: bool = False
) -> pd.DataFrame:
    """Compute the median indicator of each algorithm for every problem and evaluation count.

    Failed runs are omitted, and the sign of the indicator is such that larger is better. For a run
    with zero hypervolume, the negative additive epsilon is used instead, so that fronts beyond the
    reference point still differ. Algorithms without a finished run on a problem have minus
    infinity.

    Parameters
    ----------
    comparisons : mapping of str to Comparison
        Comparisons by problem label.
    per_variable : bool
        Whether to divide evaluation counts by the number of variables.

    Returns
    -------
    DataFrame
        One row per ``problem`` and ``evaluations``, with the ``function`` of the problem (its label
        if the problem declares none, see ``docs/tutorials/plugin.md``), its number of
        ``variables``, and one column per algorithm. Tables of several studies can be concatenated.
    """
    rows = [
        row
        for label, comparison in comparisons.items()
        for row in _build_problem_rows(label, comparison, per_variable)
    ]
    return pd.DataFrame(rows)


def compute_average_ranks(values: pd.DataFrame, control: str | None = None) -> pd.DataFrame:
    """Rank the algorithms over all problems, and test them against a control algorithm.

    Ranks are averaged for each evaluation count that all problems have in common. Instances and
    sizes of one function are not independent problems, so each function counts once: ranks are
    averaged over the problems of a function first, then over functions. For the tests, the signed
    ranks of the differences on all problems are averaged over each function. With one problem per
    function, this is Wilcoxon's signed-rank test (1945), as recommended by Demsar (2006).

    Parameters
    ----------
    values : DataFrame
        Table of `compute_problem_values`. Algorithms with a missing value (NaN) are omitted.
    control : str, optional
        Label of the algorithm that is tested against every other algorithm. By default, or if this
        algorithm is omitted, the best algorithm of each evaluation count. Choose it before
        results are available.

    Returns
    -------
    DataFrame
        One row per number of ``variables`` (0 for all problems together), ``evaluations`` and
        ``algorithm``, best first, with these columns:

        problems
            Number of problems.
        average_rank
            Average rank; 1 is the best.
        share_control_better
            Share of problems on which the control is better; ties count half.
        functions
            Number of functions.
        n_functions_control_better
            Number of functions on most of whose problems the control is better; ties count half.
        p_holm
            p value of the signed-rank test against the control, with Holm's correction.
    """
    table = values.dropna(axis="columns")
    columns = [name for name in table.columns if name not in KEY_COLUMNS]
    sizes = [0, *sorted(table["variables"].unique())]
    rows: list[dict[str, object]] = []
    for variables in sizes if len(sizes) > 2 else [0]:
        group = table if variables == 0 else table[table["variables"] == variables]
        counts = group["evaluations"].value_counts()
        for evaluations in sorted(counts.index[counts == counts.max()]):
            selected = group[group["evaluations"] == evaluations]
            keys = {"variables": variables, "evaluations": evaluations}
            ranked = _rank_algorithms(selected[columns], selected["function"], control)
            rows += [keys | row for row in ranked]
    return pd.DataFrame(rows)


def compute_friedman_test(values: pd.DataFrame) -> FriedmanResult | None:
    """Apply Friedman's test to the final median indicators of the algorithms.

    Each function is one block: the ranks on its problems are averaged.

    Parameters
    ----------
    values : DataFrame
        Table of `compute_problem_values`.

    Returns
    -------
    FriedmanResult or None
        None for fewer than two functions or algorithms.
    """
    last = values.loc[values.groupby("problem", sort=False)["evaluations"].idxmax()]
    table = last.drop(columns=list(KEY_COLUMNS)).dropna(axis="columns")
    if min(last["function"].nunique(), table.shape[1]) < 2:
        return None
    return friedman_test(table.to_numpy(float), list(table.columns), last["function"].tolist())


def compute_runtimes(comparisons: Mapping[str, Comparison]) -> dict[str, FloatArray]:
    """Return the evaluations per variable that each run needs to reach hypervolume targets.

    The targets of a problem are below the best final hypervolume of all runs by the shares
    `TARGET_DISTANCES`. Runtimes are resolved to the evaluation counts of the study. Failed runs
    reach no target, and no run reaches a target if the best hypervolume is zero.

    Parameters
    ----------
    comparisons : mapping of str to Comparison
        Comparisons by problem label.

    Returns
    -------
    dict of str to array, shape (n_problems * n_runs * n_targets,)
        Ascending runtimes by algorithm, infinite for targets that were not reached. Empty if a
        problem has no hypervolume.
    """
    times_by_algorithm: dict[str, list[FloatArray]] = {}
    for comparison in comparisons.values():
        if comparison.select_indicator().name != "hypervolume":
            return {}
        best = float(comparison.table["hypervolume"].max())
        targets = best * (1.0 - TARGET_DISTANCES)
        for name in comparison.algorithms:
            n_runs = int((comparison.runs["algorithm"] == name).sum())
            times = np.full((n_runs, len(targets)), np.inf)
            rows = comparison.table[comparison.table["algorithm"] == name]
            if len(rows):
                wide = rows.pivot(index="seed", columns="evaluations", values="hypervolume")
                evaluations = wide.columns.to_numpy(float)
                # Rounding can decrease the hypervolume of a growing front by its last digit.
                best_so_far = np.maximum.accumulate(wide.to_numpy(float), axis=1)
                reached = (best_so_far[:, :, None] >= targets) & (best > 0.0)
                first = np.where(reached.any(axis=1), evaluations[reached.argmax(axis=1)], np.inf)
                times[: len(first)] = first
            times_by_algorithm.setdefault(name, []).append(times.ravel() / comparison.problem.n_var)
    return {name: np.sort(np.concatenate(times)) for name, times in times_by_algorithm.items()}


def compute_runtime_distribution(comparisons: Mapping[str, Comparison]) -> pd.DataFrame:
    """Return the share of hypervolume targets that each algorithm reaches over its evaluations.

    Parameters
    ----------
    comparisons : mapping of str to Comparison
        Comparisons by problem label.

    Returns
    -------
    DataFrame
        Columns ``algorithm``, ``evaluations`` (per variable, ascending), and ``share``, the share
        of all targets, runs and problems reached within this number of evaluations (see
        `compute_runtimes`). An algorithm that reached no target has one row of zeros. Empty if a
        problem has no hypervolume.
    """
    rows: list[tuple[str, float, float]] = []
    for name, times in compute_runtimes(comparisons).items():
        reached = times[np.isfinite(times)]
        evaluations, counts = np.unique(reached, return_counts=True)
        shares = counts.cumsum() / len(times)
        rows += [(name, *step) for step in zip(evaluations, shares, strict=True)] or [
            (name, 0.0, 0.0)
        ]
    return pd.DataFrame(rows, columns=["algorithm", "evaluations", "share"])


def _build_problem_rows(
    label: str, comparison: Comparison, per_variable: bool
) -> list[dict[Hashable, object]]:
    indicator, table = comparison.select_indicator(), comparison.table
    value = indicator.negate_if_minimized(table[indicator.name].to_numpy(float))
    if indicator.name == "hypervolume":
        value = np.where(value > 0, value, -table["epsilon"].to_numpy(float))
    n_var, function = comparison.problem.n_var, get_function_name(comparison.problem) or label
    medians = (
        table.assign(value=value).groupby(["evaluations", "algorithm"])["value"].median().unstack()
    )
    counts = medians.index.to_numpy(float) / (n_var if per_variable else 1)
    rows = medians.reindex(columns=list(comparison.algorithms), fill_value=-np.inf).to_dict(
        "records"
    )
    return [
        dict(zip(KEY_COLUMNS, (label, function, n_var, count), strict=True)) | row
        for count, row in zip(counts, rows, strict=True)
    ]


def _rank_algorithms(
    values: pd.DataFrame, functions: pd.Series[str], control: str | None
) -> list[dict[str, object]]:
    """Rank the algorithms, and test each one against the control.

    Parameters
    ----------
    values : DataFrame
        Value of each algorithm (column) on each problem (row).
    functions : Series
        Function of each problem.
    control : str or None
        Label of the control algorithm.
    """
    table, blocks = values.to_numpy(float), functions.to_numpy()
    ranks = mean_block_ranks(table, blocks).mean(axis=0)
    order = np.argsort(ranks, kind="stable")
    names = list(values.columns)
    control_index = names.index(control) if control in names else int(order[0])
    control_values = table[:, control_index]
    is_better = (control_values[:, None] > table) + 0.5 * (control_values[:, None] == table)
    function_shares = pd.DataFrame(is_better).groupby(blocks).mean().to_numpy()
    n_functions_better = ((function_shares > 0.5) + 0.5 * (function_shares == 0.5)).sum(axis=0)
    others, p = order[order != control_index], np.full(len(order), np.nan)
    p[others] = holm_correction(
        [_signed_rank_test(control_values, table[:, i], blocks) for i in others]
    )
    return [
        {
            "algorithm": names[i],
            "problems": len(table),
            "average_rank": ranks[i],
            "share_control_better": np.nan if i == control_index else is_better[:, i].mean(),
            "functions": len(function_shares),
            "n_functions_control_better": np.nan if i == control_index else n_functions_better[i],
            "p_holm": p[i],
        }
        for i in order
    ]


def _signed_rank_test(a: FloatArray, b: FloatArray, blocks: NDArray[Any]) -> float:
    """Return the two-sided p value of Wilcoxon's signed-rank test.

    Signed ranks are averaged over the problems of each block, such as the instances of a function.
    """
    is_different = a != b
    differences = a[is_different] - b[is_different]
    signed = np.sign(differences) * scipy.stats.rankdata(np.abs(differences))
    means = pd.Series(signed).groupby(blocks[is_different]).mean()
    means = means[means != 0.0]
    return float(scipy.stats.wilcoxon(means).pvalue) if len(means) else 1.0
