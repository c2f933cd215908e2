"""Results of a comparison, and what follows from them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from mgeo.plugins.protocol import column_names
from mgeo.studies.indicators import Indicator, applicable, parts_of
from mgeo.studies.statistics import KruskalWallis, kruskal_wallis, mean_ranks, pairwise
from mgeo.studies.tables import problem_table

if TYPE_CHECKING:
    import plotly.graph_objects as go
    from pymoo.core.problem import Problem

    from mgeo._typing import FloatArray
    from mgeo.studies.indicators import IndicatorSpace
    from mgeo.studies.record import StudyRun

_LINE = 80  # characters


class ComparisonWarning(RuntimeWarning):
    """A comparison has to be read with care, as its `notes` say."""


class FailedRunsWarning(ComparisonWarning):
    """All runs of an algorithm failed, so that there is nothing to compare it by."""


@dataclass(frozen=True, eq=False)
class Tests:
    """Statistical tests of whether algorithms differ; see `statistics` for the columns.

    Attributes
    ----------
    indicator : by which algorithms were compared.
    pairs : a row for each two of them.
    kruskal_wallis : whether there is any difference at all, None for fewer than two.

    Examples
    --------
    >>> from pymoo.algorithms.moo.nsga2 import NSGA2
    >>> from pymoo.problems.multi import ZDT1
    >>> from mgeo import MGEOReal, compare
    >>> algorithms = [MGEOReal(0.1), NSGA2(20)]
    >>> comparison = compare(ZDT1(n_var=2), algorithms, n_eval=200, seeds=3, progress=False)
    >>> comparison.tests("hypervolume").indicator
    'hypervolume'
    """

    indicator: str
    pairs: pd.DataFrame
    kruskal_wallis: KruskalWallis | None


@dataclass(frozen=True, eq=False, repr=False)
class Comparison:
    """Runs of several algorithms on one problem, measured in one space.

    It prints as its `overview`, after `n_eval` evaluations.

    Attributes
    ----------
    table : one row per algorithm, seed and number of ``evaluations`` of the grid, in that order,
        with the indicators, the number of ``points`` on the front, and the columns of the problem's
        ``front_summary``. It does not depend on where or in what order runs were made.
    runs : one row per run: whether it finished, its wall time [s], how many of its evaluations
        failed, its error if it failed as a whole.
    records : the finished runs by (algorithm, seed).
    space : where the indicators were measured.
    notes : sentences on reasons to read it with care, such as a noisy problem or runs that do not
        repeat.

    Examples
    --------
    >>> from pymoo.algorithms.moo.nsga2 import NSGA2
    >>> from pymoo.problems.multi import ZDT1
    >>> from mgeo import MGEOReal, compare
    >>> algorithms = [MGEOReal(0.1), NSGA2(20)]
    >>> comparison = compare(ZDT1(n_var=2), algorithms, n_eval=200, seeds=[7], progress=False)
    >>> comparison.algorithms
    ('MGEOReal', 'NSGA2')
    """

    problem: Problem
    algorithms: tuple[str, ...]
    n_eval: int
    table: pd.DataFrame
    runs: pd.DataFrame
    records: Mapping[tuple[str, int], StudyRun]
    space: IndicatorSpace
    notes: tuple[str, ...] = ()

    def __repr__(self) -> str:
        name = type(self.problem).__name__
        table = self.overview().to_string(line_width=_LINE)
        return f"{name}, {self.n_eval:,} evaluations, mean ± sd\n{table}"

    @property
    def indicators(self) -> list[Indicator]:
        """Indicators that were measured; the first is the default everywhere."""
        return applicable(self.problem.n_obj)

    @property
    def parts(self) -> list[Indicator]:
        """Hypervolume by parts of the front, if it was measured."""
        return [
            part
            for part in parts_of(self.space, self.objectives[0])
            if part.name in self.table.columns
        ]

    @property
    def measures(self) -> list[Indicator]:
        """All `indicators` and `parts`."""
        return [*self.indicators, *self.parts]

    @property
    def objectives(self) -> tuple[str, ...]:
        """Names of the objectives, with units."""
        return column_names(self.problem)[1]

    def indicator(self, name: str | None = None) -> Indicator:
        """Return one of `indicators` or `parts` by name; None for the first.

        Raises
        ------
        ValueError
            If there is no indicator of this name.
        """
        known = {indicator.name: indicator for indicator in self.measures}
        if name is not None and name not in known:
            raise ValueError(f"indicator = {name!r}: expected one of {', '.join(known)}")
        return known[name or next(iter(known))]

    def final(self) -> pd.DataFrame:
        """Return the rows of the table after all evaluations."""
        return self.table[self.table["evaluations"] == self.n_eval].reset_index(drop=True)

    def fronts(self, algorithm: str) -> list[FloatArray]:
        """Return the final fronts of an algorithm's finished runs, (n, n_obj) each."""
        return [r.front_F for (name, _), r in self.records.items() if name == algorithm]

    def failures(self, label: str, *, everywhere: bool = False) -> list[str]:
        """Return a sentence on each algorithm with failed runs, or only failed runs.

        Parameters
        ----------
        label : name of the problem in the sentence.
        everywhere : whether only algorithms of which all runs failed are meant.
        """
        sentences = []
        for name, runs in self.runs.groupby("algorithm", sort=False):
            errors = runs.loc[runs["status"] == "failed", "error"]
            if len(errors) >= (len(runs) if everywhere else 1):
                sentences.append(
                    f"{name} on {label}: {len(errors)} of {len(runs)} runs failed, the first with "
                    f"{errors.iloc[0]}"
                )
        return sentences

    def samples(self, indicator: str | None = None) -> dict[str, FloatArray]:
        """Return the final values of each algorithm's finished runs, larger being better."""
        chosen = self.indicator(indicator)
        return {
            str(name): chosen.better(group[chosen.name].to_numpy(float))
            for name, group in self.final().groupby("algorithm", sort=False)
        }

    def order(self, indicator: str | None = None) -> list[str]:
        """Return the algorithms with a finished run, the best mean rank of runs first.

        The tests use the same ranks. An order by means would differ where a few runs are far from
        the others.

        Raises
        ------
        ValueError
            If the indicator is unknown.
        """
        return [str(name) for name in mean_ranks(self.samples(indicator)).index]

    def median_seed(self, algorithm: str) -> int | None:
        """Return the seed of the run with the median first indicator (the better of two)."""
        final, chosen = self.final(), self.indicator()
        rows = final[final["algorithm"] == algorithm]
        order = chosen.better(rows[chosen.name]).sort_values(ascending=False, kind="stable").index
        return int(rows.loc[order[(len(order) - 1) // 2], "seed"]) if len(order) else None

    def summary(self) -> pd.DataFrame:
        """Return, per algorithm, the finished runs, and statistics of each column of the table.

        The columns have two levels: column, and mean, sd (of the sample), median, min and max.
        """
        final = self.final().drop(columns=["seed", "evaluations"])
        groups = final.groupby("algorithm", sort=False)
        statistics = groups.agg(["mean", "std", "median", "min", "max"])
        statistics = statistics.rename(columns={"std": "sd"}, level=1)
        statistics.insert(0, ("runs", ""), groups.size())
        return statistics.reindex(self.algorithms)

    def tests(self, indicator: str | None = None) -> Tests:
        """Return the tests of all pairs and of all algorithms at once.

        Pairs are compared by the Mann-Whitney test with Holm's correction and effect sizes, all at
        once by that of Kruskal and Wallis. Every finished run counts, with the worst value if it
        has no front.

        Raises
        ------
        ValueError
            If the indicator is unknown.
        """
        samples = self.samples(indicator)
        overall = kruskal_wallis(samples) if len(samples) > 1 else None
        return Tests(self.indicator(indicator).name, pairwise(samples), overall)

    def overview(self) -> pd.DataFrame:
        """Return, per algorithm as text, the runs, and mean ± sd of every column of the table.

        Columns of indicators have their titles as names.
        """
        summary = self.summary()
        columns: dict[str, Any] = {"runs": [str(int(n)) for n in summary[("runs", "")].fillna(0)]}
        for name in dict.fromkeys(summary.columns.get_level_values(0).drop("runs")):
            mean, sd = summary[(name, "mean")], summary[(name, "sd")]
            columns[name] = [_mean_and_sd(m, s) for m, s in zip(mean, sd, strict=True)]
        titles = {each.name: each.title for each in self.measures}
        return pd.DataFrame(columns, index=summary.index).rename(columns=titles)

    def to_latex(self) -> str:
        """Return the `overview` as a booktabs table and a note.

        The best mean by each indicator is bold, and what does not differ significantly from it is
        marked.
        """
        return problem_table(self).latex()

    def to_markdown(self) -> str:
        """Return the `overview` in Markdown, marked as in `to_latex`."""
        return problem_table(self).markdown()

    def figures(self) -> dict[str, go.Figure]:
        """Draw all figures that apply: anytime, boxes, fronts, each, attainment, difference.

        Fronts need two or three objectives, all after them two. The difference is that of the two
        best algorithms with a front.
        """
        from mgeo.studies.figures import fronts, indicators

        figures = {
            "anytime": indicators.anytime_figure(self),
            "boxes": indicators.boxes_figure(self),
        }
        ranked = [name for name in self.order() if any(map(len, self.fronts(name)))]
        if ranked and self.problem.n_obj in (2, 3):
            figures["fronts"] = fronts.fronts_figure(self)
        if ranked and self.problem.n_obj == 2:
            figures["each"] = fronts.each_figure(self)
            figures["attainment"] = fronts.attainment_figure(self)
            if len(ranked) > 1:
                figures["difference"] = fronts.difference_figure(self, *ranked[:2])
        return figures


def _mean_and_sd(mean: float, sd: float) -> str:
    """Format mean ± sd, the sd with two digits."""
    if not np.isfinite(mean):
        return "-" if np.isnan(mean) else str(mean)
    if not np.isfinite(sd) or sd == 0:
        return f"{mean:.6g}"
    exponent = int(f"{sd:.1e}".partition("e")[2])  # of the rounded value: 0.0999 is 0.10
    digits = min(max(1 - exponent, 0), 12)
    return f"{mean:.{digits}f} ± {sd:.{digits}f}"
