"""Results over problems: ranks after each budget, and runtimes to targets of the hypervolume."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from typing import Any

import numpy as np
import pandas as pd
import scipy  # its `stats` takes long to import, and only when it is used
from numpy.typing import NDArray

from mgeo._typing import FloatArray
from mgeo.plugins.protocol import instance_of
from mgeo.studies.comparison import Comparison
from mgeo.studies.statistics import Friedman, friedman, holm, ranks_of_blocks

KEYS = ("problem", "function", "variables", "evaluations")

#: Shares of the best value by which a run may fall short of it: ten to a power of ten, to 1e-5.
SHORTFALLS = 10.0 ** np.linspace(-0.1, -5.0, 50)


def problem_values(results: Mapping[str, Comparison], per_variable: bool = False) -> pd.DataFrame:
    """What each algorithm reaches on each problem after each number of evaluations.

    A problem's value for an algorithm is the median over its runs of the first indicator, larger
    being better. A run whose hypervolume is zero counts by the negative of its additive epsilon
    instead: fronts that are all too far to dominate anything still differ. Runs that failed are
    left out; an algorithm of which all runs of a problem failed has minus infinity there, as one
    that found nothing feasible.

    Parameters
    ----------
    results : by problem.
    per_variable : whether evaluations are counted per variable.

    Returns
    -------
    A row per ``problem``, with the ``function`` that it is an instance of (its own label for a
    problem that does not say, see ``docs/plugins.md``), its number of ``variables``, and
    ``evaluations``; a column per algorithm. Tables of several studies can be concatenated.
    """
    rows = [row for label, each in results.items() for row in _values(label, each, per_variable)]
    return pd.DataFrame(rows)


def ranks_over_problems(values: pd.DataFrame, control: str | None = None) -> pd.DataFrame:
    """Average ranks over problems after each number of evaluations that all of them have.

    Instances and sizes of one function are no independent problems. So each function counts once:
    ranks are averaged over its problems first, then over functions; and the two algorithms of a
    test are compared by the signed ranks of their differences on all problems, averaged over those
    of a function. Where each function has one problem, that is the usual test.

    Parameters
    ----------
    values : as of `problem_values`. Algorithms that were not run on every problem (NaN, where
        tables of several studies were concatenated) are left out.
    control : the algorithm that is tested against each other one; None, or one that is left out,
        for the best of each row. Named before there are results it makes a test of these alone.

    Returns
    -------
    A row per number of ``variables`` (0 for all problems together), ``evaluations`` and
    ``algorithm``, the best first, with the number of ``problems``, the ``average_rank`` (1 is the
    best), ``behind``, the share of problems on which the control, or the best, is better than it
    (ties count half), ``functions``, their number, ``functions_behind``, on how many the control
    is better on most of their problems (ties count half), and ``p_holm`` of Wilcoxon's signed-rank
    test (1945) of the two over functions, corrected for all of the row's rivals. Demsar (2006)
    recommends test and ranks.
    """
    table = values.dropna(axis="columns")
    columns = [name for name in table.columns if name not in KEYS]
    groups = [0, *sorted(table["variables"].unique())]
    rows: list[dict[str, object]] = []
    for variables in groups if len(groups) > 2 else [0]:
        of_size = table if variables == 0 else table[table["variables"] == variables]
        counts = of_size["evaluations"].value_counts()
        for evaluations in sorted(counts.index[counts == counts.max()]):
            now = of_size[of_size["evaluations"] == evaluations]
            standing = {"variables": variables, "evaluations": evaluations}
            rows += [standing | row for row in _ranked(now[columns], now["function"], control)]
    return pd.DataFrame(rows)


def friedman_over_problems(values: pd.DataFrame) -> Friedman | None:
    """Friedman's test with functions as blocks, by their values after most evaluations.

    None for fewer than two functions or algorithms.

    Parameters
    ----------
    values : as of `problem_values`; see `ranks_over_problems`.
    """
    last = values.loc[values.groupby("problem", sort=False)["evaluations"].idxmax()]
    table = last.drop(columns=list(KEYS)).dropna(axis="columns")
    if min(last["function"].nunique(), table.shape[1]) < 2:
        return None
    return friedman(table.to_numpy(float), list(table.columns), last["function"].tolist())


def runtimes(results: Mapping[str, Comparison]) -> dict[str, FloatArray]:
    """Return the evaluations per variable that each run on each problem took to each target.

    A problem's targets are hypervolumes that fall short of the best final one of all runs by
    `SHORTFALLS`. Runs are examined where their indicators were measured (the study's grid). A run
    that failed reached no target. No run reached any where the best hypervolume is zero.

    Returns
    -------
    By algorithm, (n_problems x n_runs x n_targets,) numbers, ascending; infinite where a target
    was not reached. Without algorithms if a problem has no hypervolume.
    """
    found: dict[str, list[FloatArray]] = {}
    for each in results.values():
        if each.indicator().name != "hypervolume":
            return {}
        best = float(each.table["hypervolume"].max())
        targets = best * (1.0 - SHORTFALLS)
        for name in each.algorithms:
            n_runs = int((each.runs["algorithm"] == name).sum())
            times = np.full((n_runs, len(targets)), np.inf)
            rows = each.table[each.table["algorithm"] == name]
            if len(rows):
                wide = rows.pivot(index="seed", columns="evaluations", values="hypervolume")
                evaluations = wide.columns.to_numpy(float)
                # a front that grew may measure less in its last digit
                so_far = np.maximum.accumulate(wide.to_numpy(float), axis=1)
                reached = (so_far[:, :, None] >= targets) & (best > 0.0)
                first = np.where(reached.any(axis=1), evaluations[reached.argmax(axis=1)], np.inf)
                times[: len(first)] = first
            found.setdefault(name, []).append(times.ravel() / each.problem.n_var)
    return {name: np.sort(np.concatenate(times)) for name, times in found.items()}


def targets_reached(results: Mapping[str, Comparison]) -> pd.DataFrame:
    """Return the empirical distribution of `runtimes`: steps of each algorithm's curve.

    Columns ``algorithm``, ``evaluations`` per variable, ascending, and ``share``, that of all
    targets, of all runs on all problems, that are reached within them; a row of zeros for an
    algorithm that reached none. Empty if a problem has no hypervolume.
    """
    rows: list[tuple[str, float, float]] = []
    for name, times in runtimes(results).items():
        reached = times[np.isfinite(times)]
        x, counts = np.unique(reached, return_counts=True)
        shares = counts.cumsum() / len(times)
        rows += [(name, *step) for step in zip(x, shares, strict=True)] or [(name, 0.0, 0.0)]
    return pd.DataFrame(rows, columns=["algorithm", "evaluations", "share"])


def _values(label: str, each: Comparison, per_variable: bool) -> list[dict[Hashable, object]]:
    """Of a problem: a row per number of evaluations, with the value of each algorithm."""
    first, table = each.indicator(), each.table
    value = first.better(table[first.name].to_numpy(float))
    if first.name == "hypervolume":
        value = np.where(value > 0, value, -table["epsilon"].to_numpy(float))
    n_var, function = each.problem.n_var, instance_of(each.problem) or label
    medians = (
        table.assign(value=value).groupby(["evaluations", "algorithm"])["value"].median().unstack()
    )
    counts = medians.index.to_numpy(float) / (n_var if per_variable else 1)
    known = medians.reindex(columns=list(each.algorithms), fill_value=-np.inf).to_dict("records")
    return [
        dict(zip(KEYS, (label, function, n_var, count), strict=True)) | row
        for count, row in zip(counts, known, strict=True)
    ]


def _ranked(
    values: pd.DataFrame, functions: pd.Series[str], control: str | None
) -> list[dict[str, object]]:
    """Algorithms of (problems, algorithms) values, larger being better, the best first."""
    table, blocks = values.to_numpy(float), functions.to_numpy()
    ranks = ranks_of_blocks(table, blocks).mean(axis=0)
    order = np.argsort(ranks, kind="stable")
    names = list(values.columns)
    one = names.index(control) if control in names else int(order[0])
    own = table[:, one]
    ahead = (own[:, None] > table) + 0.5 * (own[:, None] == table)
    of_functions = pd.DataFrame(ahead).groupby(blocks).mean().to_numpy()
    most = ((of_functions > 0.5) + 0.5 * (of_functions == 0.5)).sum(axis=0)
    rivals, p = order[order != one], np.full(len(order), np.nan)
    p[rivals] = holm([_signed_ranks(own, table[:, i], blocks) for i in rivals])
    return [
        {
            "algorithm": names[i],
            "problems": len(table),
            "average_rank": ranks[i],
            "behind": np.nan if i == one else ahead[:, i].mean(),
            "functions": len(of_functions),
            "functions_behind": np.nan if i == one else most[i],
            "p_holm": p[i],
        }
        for i in order
    ]


def _signed_ranks(a: FloatArray, b: FloatArray, blocks: NDArray[Any]) -> float:
    """Two-sided p of Wilcoxon's test that paired values are equally often larger, over blocks."""
    differ = a != b
    differences = a[differ] - b[differ]
    signed = np.sign(differences) * scipy.stats.rankdata(np.abs(differences))
    means = pd.Series(signed).groupby(blocks[differ]).mean()
    means = means[means != 0.0]
    return float(scipy.stats.wilcoxon(means).pvalue) if len(means) else 1.0
