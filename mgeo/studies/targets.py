"""Runtimes: how soon runs reach targets of the hypervolume."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd

from mgeo._typing import FloatArray
from mgeo.studies.comparison import Comparison

#: Shares of the best value by which a run may fall short of it: ten to a power of ten, to 1e-5.
SHORTFALLS = 10.0 ** np.linspace(-0.1, -5.0, 50)


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
