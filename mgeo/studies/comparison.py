"""What a comparison found."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from mgeo.plugins.protocol import column_names
from mgeo.studies.indicators import Indicator, applicable
from mgeo.studies.statistics import KruskalWallis, kruskal_wallis, mean_ranks, pairwise
from mgeo.studies.tables import latex

if TYPE_CHECKING:
    import plotly.graph_objects as go
    from pymoo.core.problem import Problem

    from mgeo._typing import FloatArray
    from mgeo.studies.record import Record
    from mgeo.studies.space import IndicatorSpace

KEYS = ("algorithm", "seed", "evaluations")


@dataclass(frozen=True, eq=False)
class Tests:
    """Whether algorithms differ in an indicator; see `statistics` for the columns."""

    indicator: str
    pairs: pd.DataFrame
    kruskal_wallis: KruskalWallis | None


@dataclass(frozen=True, eq=False)
class Comparison:
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
    records: Mapping[tuple[str, int], Record]
    space: IndicatorSpace

    @property
    def indicators(self) -> list[Indicator]:
        """Those measured; the first is what everything shows by default."""
        return applicable(self.problem.n_obj)

    @property
    def objectives(self) -> tuple[str, ...]:
        """Names of the objectives, with units."""
        return column_names(self.problem)[1]

    def final(self) -> pd.DataFrame:
        """The rows of the table after all evaluations."""
        return self.table[self.table["evaluations"] == self.n_eval].reset_index(drop=True)

    def fronts(self, algorithm: str) -> list[FloatArray]:
        """The final fronts of an algorithm's finished runs, (n, n_obj) each."""
        return [r.front_F for (name, _), r in self.records.items() if name == algorithm]

    def summary(self) -> pd.DataFrame:
        """Per algorithm: number of finished runs; of each column mean, sd, median, min and max.

        The columns have two levels; sd is the sample's standard deviation.
        """
        final = self.final().drop(columns=["seed", "evaluations"])
        groups = final.groupby("algorithm", sort=False)
        statistics = groups.agg(["mean", "std", "median", "min", "max"])
        statistics = statistics.rename(columns={"std": "sd"}, level=1)
        statistics.insert(0, ("runs", ""), groups.size())
        return statistics.reindex(self.algorithms)

    def tests(self, indicator: str | None = None) -> Tests:
        """Mann-Whitney tests of all pairs, with Holm's correction and effect sizes, and that of
        Kruskal and Wallis of all at once (None for fewer than two algorithms).

        Every finished run counts, with the worst value if it has no front.

        Raises
        ------
        ValueError
            If the indicator is unknown.
        """
        samples = self._samples(indicator)
        overall = kruskal_wallis(samples) if len(samples) > 1 else None
        return Tests(self.indicator(indicator).name, pairwise(samples), overall)

    def overview(self) -> pd.DataFrame:
        """Per algorithm, as text: mean ± sd of every column of the table, and the runs.

        Columns of indicators have their titles as names.
        """
        summary = self.summary()
        columns: dict[str, Any] = {"runs": [str(int(n)) for n in summary[("runs", "")].fillna(0)]}
        for name in dict.fromkeys(summary.columns.get_level_values(0).drop("runs")):
            mean, sd = summary[(name, "mean")], summary[(name, "sd")]
            columns[name] = [_shown(m, s) for m, s in zip(mean, sd, strict=True)]
        titles = {indicator.name: indicator.title for indicator in self.indicators}
        return pd.DataFrame(columns, index=summary.index).rename(columns=titles)

    def to_latex(self) -> str:
        """The `overview` as a booktabs table; by each indicator the first of `order` in bold."""
        bold = {(name, i.title) for i in self.indicators for name in self.order(i.name)[:1]}
        return latex(self.overview(), bold)

    def figures(self) -> dict[str, go.Figure]:
        """All figures that the number of objectives, algorithms and runs allows, by name."""
        from mgeo.figures.comparison import comparison_figures

        return comparison_figures(self)

    def indicator(self, name: str | None = None) -> Indicator:
        """One of `indicators` by name; None for the first.

        Raises
        ------
        ValueError
            If it is none of them.
        """
        known = {indicator.name: indicator for indicator in self.indicators}
        if name is not None and name not in known:
            raise ValueError(f"indicator = {name!r}: expected one of {', '.join(known)}")
        return known[name or next(iter(known))]

    def order(self, indicator: str | None = None) -> list[str]:
        """Algorithms with a finished run, the one with the best mean rank of its runs first.

        These are the ranks that the tests are made of. An order by means would be another one
        where a few runs are far from the others.

        Raises
        ------
        ValueError
            If the indicator is unknown.
        """
        return [str(name) for name in mean_ranks(self._samples(indicator)).index]

    def median_seed(self, algorithm: str) -> int | None:
        """Seed of the run with the median of the first indicator (the better of two), if any."""
        final, chosen = self.final(), self.indicator()
        rows = final[final["algorithm"] == algorithm]
        order = chosen.better(rows[chosen.name]).sort_values(ascending=False, kind="stable").index
        return int(rows.loc[order[(len(order) - 1) // 2], "seed"]) if len(order) else None

    def _samples(self, indicator: str | None) -> dict[str, FloatArray]:
        """The final values of each algorithm's finished runs, turned so that larger is better."""
        chosen = self.indicator(indicator)
        return {
            str(name): chosen.better(group[chosen.name].to_numpy(float))
            for name, group in self.final().groupby("algorithm", sort=False)
        }


def _shown(mean: float, sd: float) -> str:
    """Mean ± sd, with as many digits as the sd (two of its own) makes sensible."""
    if not np.isfinite(mean):
        return "-" if np.isnan(mean) else str(mean)
    if not np.isfinite(sd) or sd == 0:
        return f"{mean:.6g}"
    exponent = int(f"{sd:.1e}".partition("e")[2])  # of the rounded value: 0.0999 is 0.10
    digits = min(max(1 - exponent, 0), 12)
    return f"{mean:.{digits}f} ± {sd:.{digits}f}"
