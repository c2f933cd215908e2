"""Runs of several algorithms on one problem, measured, and how soon they reach targets."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from mgeo.plugins.protocol import column_names
from mgeo.studies.indicators import Indicator, applicable, parts_of
from mgeo.studies.statistics import mean_ranks

if TYPE_CHECKING:
    import pandas as pd
    from pymoo.core.problem import Problem

    from mgeo._typing import FloatArray
    from mgeo.store.study_run import StudyRun
    from mgeo.studies.indicators import IndicatorSpace

#: Shares of the best value by which a run may fall short of it: ten to a power of ten, to 1e-5.
SHORTFALLS = 10.0 ** np.linspace(-0.1, -5.0, 50)


class FailedRunsWarning(RuntimeWarning):
    """All runs of an algorithm failed, so that there is nothing to compare it by."""


class NotReusedWarning(RuntimeWarning):
    """Runs are not kept, or not used, because nobody knows for certain what they are runs of."""


@dataclass(frozen=True, eq=False)
class Results:
    """Runs of several algorithms on one problem, measured in one space.

    Attributes
    ----------
    table : tidy: one row per algorithm, seed and number of ``evaluations`` of the grid, in that
        order, with the indicators, the number of ``points`` on the front, and the columns of the
        problem's ``front_summary``. It does not depend on where or in what order runs were made.
    runs : one row per run: whether it finished, its wall time [s], how many of its evaluations
        failed, its error if it failed as a whole, the versions it was made with if it did not.
    records : the finished runs by (algorithm, seed).
    space : where the indicators were measured.
    """

    problem: Problem
    algorithms: tuple[str, ...]
    n_eval: int
    table: pd.DataFrame
    runs: pd.DataFrame
    records: Mapping[tuple[str, int], StudyRun]
    space: IndicatorSpace

    @property
    def indicators(self) -> list[Indicator]:
        """Those measured; the first is what everything shows by default."""
        return applicable(self.problem.n_obj)

    @property
    def parts(self) -> list[Indicator]:
        """The hypervolume by parts of the front, if it was measured (not by mgeo 0.1)."""
        return [
            part
            for part in parts_of(self.space, self.objectives[0])
            if part.name in self.table.columns
        ]

    @property
    def objectives(self) -> tuple[str, ...]:
        """Names of the objectives, with units."""
        return column_names(self.problem)[1]

    def final(self) -> pd.DataFrame:
        """The rows of the table after all evaluations."""
        return self.table[self.table["evaluations"] == self.n_eval].reset_index(drop=True)

    def failures(self) -> pd.DataFrame:
        """Of each algorithm with runs that failed: how many did, of how many, the first error."""
        by_algorithm = self.runs.assign(failed=self.runs["status"] == "failed").groupby(
            "algorithm", sort=False
        )
        counts = by_algorithm["failed"].agg(failed="sum", runs="size")
        failed = self.runs[self.runs["status"] == "failed"]
        found: pd.DataFrame = counts.join(failed.groupby("algorithm")["error"].first(), how="inner")
        return found

    def fronts(self, algorithm: str) -> list[FloatArray]:
        """The final fronts of an algorithm's finished runs, (n, n_obj) each."""
        return [r.front_F for (name, _), r in self.records.items() if name == algorithm]

    def indicator(self, name: str | None = None) -> Indicator:
        """One of `indicators` or `parts` by name; None for the first.

        Raises
        ------
        ValueError
            If it is none of them.
        """
        known = {indicator.name: indicator for indicator in [*self.indicators, *self.parts]}
        if name is not None and name not in known:
            raise ValueError(f"indicator = {name!r}: expected one of {', '.join(known)}")
        return known[name or next(iter(known))]

    def samples(self, indicator: str | None = None) -> dict[str, FloatArray]:
        """The final values of each algorithm's finished runs, turned so that larger is better."""
        chosen = self.indicator(indicator)
        return {
            str(name): chosen.better(group[chosen.name].to_numpy(float))
            for name, group in self.final().groupby("algorithm", sort=False)
        }

    def order(self, indicator: str | None = None) -> list[str]:
        """Algorithms with a finished run, the one with the best mean rank of its runs first.

        These are the ranks that the tests are made of. An order by means would be another one
        where a few runs are far from the others.

        Raises
        ------
        ValueError
            If the indicator is unknown.
        """
        return [str(name) for name in mean_ranks(self.samples(indicator)).index]

    def median_seed(self, algorithm: str) -> int | None:
        """Seed of the run with the median of the first indicator (the better of two), if any."""
        final, chosen = self.final(), self.indicator()
        rows = final[final["algorithm"] == algorithm]
        order = chosen.better(rows[chosen.name]).sort_values(ascending=False, kind="stable").index
        return int(rows.loc[order[(len(order) - 1) // 2], "seed"]) if len(order) else None


def failures(found: pd.DataFrame, label: str) -> list[str]:
    """A sentence on each algorithm that failed on the problem of this label.

    Parameters
    ----------
    found : as of `Results.failures`.
    """
    return [
        f"{each.Index} on {label}: {each.failed} of {each.runs} runs failed, the first with "
        f"{each.error}"
        for each in found.itertuples()
    ]


def runtimes(results: Mapping[str, Results]) -> dict[str, FloatArray]:
    """Evaluations per variable until each target, of each run on each problem, was reached.

    A problem's targets are hypervolumes: those that fall short of the best final one of all runs
    by `SHORTFALLS`. Runs are looked at where their indicators were measured (the study's grid).
    A run that failed reached none, and nobody reached any where that best one is zero.

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


def targets_reached(results: Mapping[str, Results]) -> pd.DataFrame:
    """Empirical distribution of `runtimes`: steps of each algorithm's curve.

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
