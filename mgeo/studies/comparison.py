"""Result of a comparison: indicator tables, statistical tests, summaries and figures."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from mgeo.plugins.protocol import get_column_names
from mgeo.studies.indicators import Indicator, build_part_indicators, select_indicators
from mgeo.studies.statistics import (
    KruskalWallisResult,
    compare_pairwise,
    kruskal_wallis_test,
    mean_ranks,
)
from mgeo.studies.tables import build_problem_table

if TYPE_CHECKING:
    import plotly.graph_objects as go
    from pymoo.core.problem import Problem

    from mgeo._typing import FloatArray
    from mgeo.studies.indicators import IndicatorSpace
    from mgeo.studies.study_run import StudyRun

_LINE_WIDTH = 80  # Characters in a line of the representation.


class ComparisonWarning(RuntimeWarning):
    """Warning about a condition that limits the validity of a comparison."""


class FailedRunsWarning(ComparisonWarning):
    """Warning that a comparison omits an algorithm because all its runs failed."""


@dataclass(frozen=True, eq=False)
class SignificanceTests:
    """Statistical tests of the differences between algorithms in one indicator.

    Attributes
    ----------
    indicator : str
        Name of the indicator.
    pairs : DataFrame
        One row per pair of algorithms, with the columns of
        `mgeo.studies.statistics.compare_pairwise`.
    kruskal_wallis : KruskalWallisResult or None
        Test of all algorithms together; None for fewer than two algorithms.

    Examples
    --------
    >>> from pymoo.algorithms.moo.nsga2 import NSGA2
    >>> from pymoo.problems.multi import ZDT1
    >>> from mgeo import MGEOReal, compare
    >>> algorithms = [MGEOReal(0.1), NSGA2(20)]
    >>> comparison = compare(ZDT1(n_var=2), algorithms, n_eval=200, seeds=3, progress=False)
    >>> comparison.test_differences("hypervolume").indicator
    'hypervolume'
    """

    indicator: str
    pairs: pd.DataFrame
    kruskal_wallis: KruskalWallisResult | None


@dataclass(frozen=True, eq=False, repr=False)
class Comparison:
    """Runs of several algorithms on one problem, with quality indicators of their fronts.

    The indicators of all runs are computed in one indicator space. The representation is the
    `format_overview` after `n_eval` evaluations.

    Attributes
    ----------
    problem : Problem
        Problem that the algorithms solved.
    algorithms : tuple of str
        Labels of the algorithms.
    n_eval : int
        Number of evaluations of each run.
    table : DataFrame
        One row per algorithm, seed and evaluation count (``evaluations``), sorted by these three,
        with the indicators, the number of ``points`` on the front, and the columns of the problem's
        ``front_summary``. The table does not depend on the order in which the runs were executed.
    runs : DataFrame
        One row per run, with its status, wall time [s], number of failed evaluations, and error
        message if the run failed.
    finished_runs : mapping of (str, int) to StudyRun
        Finished runs by algorithm and seed.
    space : IndicatorSpace
        Scaled objective space in which the indicators are computed.
    notes : tuple of str
        Conditions that limit the validity of the comparison, such as a noisy problem or an
        algorithm that is not reproducible; one sentence each.

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
    finished_runs: Mapping[tuple[str, int], StudyRun]
    space: IndicatorSpace
    notes: tuple[str, ...] = ()

    def __repr__(self) -> str:
        name = type(self.problem).__name__
        table = self.format_overview().to_string(line_width=_LINE_WIDTH)
        return f"{name}, {self.n_eval:,} evaluations, mean ± sd\n{table}"

    @property
    def indicators(self) -> list[Indicator]:
        """Quality indicators of a whole front. The first one is the default in all methods."""
        return select_indicators(self.problem.n_obj)

    @property
    def part_indicators(self) -> list[Indicator]:
        """Hypervolume indicators of the parts into which the first objective divides a front.

        The list is empty if the parts were not evaluated.
        """
        return [
            part
            for part in build_part_indicators(self.space, self.objectives[0])
            if part.name in self.table.columns
        ]

    @property
    def all_indicators(self) -> list[Indicator]:
        """Quality indicators of a whole front, followed by those of its parts."""
        return [*self.indicators, *self.part_indicators]

    @property
    def objectives(self) -> tuple[str, ...]:
        """Names of the objectives, with units."""
        return get_column_names(self.problem)[1]

    def select_indicator(self, name: str | None = None) -> Indicator:
        """Return the quality indicator with a given name, or the default indicator for None.

        Raises
        ------
        ValueError
            If there is no indicator of this name.
        """
        indicators = {indicator.name: indicator for indicator in self.all_indicators}
        if name is not None and name not in indicators:
            raise ValueError(f"indicator = {name!r}: expected one of {', '.join(indicators)}")
        return indicators[name or next(iter(indicators))]

    def select_final_rows(self) -> pd.DataFrame:
        """Return the rows of `table` after `n_eval` evaluations, one per run."""
        return self.table[self.table["evaluations"] == self.n_eval].reset_index(drop=True)

    def list_fronts(self, algorithm: str) -> list[FloatArray]:
        """Return the objectives of the final front of each finished run of an algorithm.

        Returns
        -------
        list of arrays, shape (n, n_obj)
        """
        return [r.front_F for (name, _), r in self.finished_runs.items() if name == algorithm]

    def describe_failures(self, label: str, *, all_failed_only: bool = False) -> list[str]:
        """Describe the failed runs in one sentence per algorithm, with the first error message.

        Parameters
        ----------
        label : str
            Name of the problem in the sentences.
        all_failed_only : bool
            Whether to report only algorithms whose runs all failed.
        """
        sentences = []
        for name, runs in self.runs.groupby("algorithm", sort=False):
            errors = runs.loc[runs["status"] == "failed", "error"]
            if len(errors) >= (len(runs) if all_failed_only else 1):
                sentences.append(
                    f"{name} on {label}: {len(errors)} of {len(runs)} runs failed, the first with "
                    f"{errors.iloc[0]}"
                )
        return sentences

    def collect_final_values(self, indicator: str | None = None) -> dict[str, FloatArray]:
        """Return the final indicator values of each algorithm, negated if lower is better.

        Parameters
        ----------
        indicator : str, optional
            Name of the indicator. Default: the first of `indicators`.

        Returns
        -------
        dict of str to array, shape (n_runs,)
            Values by algorithm.
        """
        chosen = self.select_indicator(indicator)
        return {
            str(name): chosen.negate_if_minimized(group[chosen.name].to_numpy(float))
            for name, group in self.select_final_rows().groupby("algorithm", sort=False)
        }

    def rank_algorithms(self, indicator: str | None = None) -> list[str]:
        """Return the algorithms with finished runs, sorted by mean rank, best first.

        The statistical tests use the same mean rank. A few outlying runs affect it less than
        they affect the mean.

        Parameters
        ----------
        indicator : str, optional
            Name of the indicator. Default: the first of `indicators`.

        Raises
        ------
        ValueError
            If the indicator is unknown.
        """
        return [str(name) for name in mean_ranks(self.collect_final_values(indicator)).index]

    def find_median_seed(self, algorithm: str) -> int | None:
        """Return the seed of the median run of an algorithm by the default indicator.

        For an even number of runs, the better of the two middle runs is selected.

        Returns
        -------
        int or None
            None if the algorithm has no finished run.
        """
        final, chosen = self.select_final_rows(), self.select_indicator()
        rows = final[final["algorithm"] == algorithm]
        order = (
            chosen.negate_if_minimized(rows[chosen.name])
            .sort_values(ascending=False, kind="stable")
            .index
        )
        return int(rows.loc[order[(len(order) - 1) // 2], "seed"]) if len(order) else None

    def summarize(self) -> pd.DataFrame:
        """Compute statistics of the final indicator values of each algorithm.

        Returns
        -------
        DataFrame
            One row per algorithm. Columns have two levels: the column of `table`, and ``mean``,
            ``sd`` (sample standard deviation), ``median``, ``min`` and ``max``. The column ``runs``
            is the number of finished runs.
        """
        final = self.select_final_rows().drop(columns=["seed", "evaluations"])
        groups = final.groupby("algorithm", sort=False)
        statistics = groups.agg(["mean", "std", "median", "min", "max"])
        statistics = statistics.rename(columns={"std": "sd"}, level=1)
        statistics.insert(0, ("runs", ""), groups.size())
        return statistics.reindex(self.algorithms)

    def test_differences(self, indicator: str | None = None) -> SignificanceTests:
        """Test the differences between algorithms in one indicator, pairwise and overall.

        Pairs are compared by the Mann-Whitney test with Holm's correction and an effect size, all
        algorithms together by the Kruskal-Wallis test. A finished run without a front has the worst
        indicator value.

        Parameters
        ----------
        indicator : str, optional
            Name of the indicator. Default: the first of `indicators`.

        Raises
        ------
        ValueError
            If the indicator is unknown.
        """
        samples = self.collect_final_values(indicator)
        overall = kruskal_wallis_test(samples) if len(samples) > 1 else None
        return SignificanceTests(
            self.select_indicator(indicator).name, compare_pairwise(samples), overall
        )

    def format_overview(self) -> pd.DataFrame:
        """Return a text table with the mean ± standard deviation of each indicator.

        The first column is the number of finished runs. Indicator columns are named by the titles
        of the indicators.
        """
        summary = self.summarize()
        columns: dict[str, Any] = {"runs": [str(int(n)) for n in summary[("runs", "")].fillna(0)]}
        for name in dict.fromkeys(summary.columns.get_level_values(0).drop("runs")):
            mean, sd = summary[(name, "mean")], summary[(name, "sd")]
            columns[name] = [_format_mean_and_sd(m, s) for m, s in zip(mean, sd, strict=True)]
        titles = {indicator.name: indicator.title for indicator in self.all_indicators}
        return pd.DataFrame(columns, index=summary.index).rename(columns=titles)

    def to_latex(self) -> str:
        """Return the overview table in LaTeX, with the best algorithms marked.

        For each indicator, the best mean is bold, and algorithms without a significant difference
        from the best one are marked.
        """
        return build_problem_table(self).to_latex()

    def to_markdown(self) -> str:
        """Return the overview table in Markdown, with the best algorithms marked."""
        return build_problem_table(self).to_markdown()

    def draw_figures(self) -> dict[str, go.Figure]:
        """Draw all figures that apply to the problem, and return them in a dict keyed by name.

        The names are ``anytime``, ``boxes``, ``fronts`` (two or three objectives), ``panels``,
        ``attainment`` and ``difference`` (two objectives). ``difference`` compares the two best
        algorithms that have a front.
        """
        from mgeo.studies.figures import fronts, indicators

        figures = {
            "anytime": indicators.draw_anytime_curves(self),
            "boxes": indicators.draw_box_plots(self),
        }
        ranked = [name for name in self.rank_algorithms() if any(map(len, self.list_fronts(name)))]
        if ranked and self.problem.n_obj in (2, 3):
            figures["fronts"] = fronts.draw_median_fronts(self)
        if ranked and self.problem.n_obj == 2:
            figures["panels"] = fronts.draw_front_panels(self)
            figures["attainment"] = fronts.draw_attainment_surfaces(self)
            if len(ranked) > 1:
                figures["difference"] = fronts.draw_attainment_difference(self, *ranked[:2])
        return figures


def _format_mean_and_sd(mean: float, sd: float) -> str:
    """Format mean ± standard deviation, rounded to two significant digits of the deviation."""
    if not np.isfinite(mean):
        return "-" if np.isnan(mean) else str(mean)
    if not np.isfinite(sd) or sd == 0:
        return f"{mean:.6g}"
    exponent = int(
        f"{sd:.1e}".partition("e")[2]
    )  # The exponent is read after rounding, because 0.0999 becomes 0.10.
    digits = min(max(1 - exponent, 0), 12)
    return f"{mean:.{digits}f} ± {sd:.{digits}f}"
