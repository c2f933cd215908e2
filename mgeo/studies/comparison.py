"""What a comparison found."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from mgeo.studies.results import Results
from mgeo.studies.statistics import KruskalWallis, kruskal_wallis, pairwise
from mgeo.studies.tables import problem_table

if TYPE_CHECKING:
    import plotly.graph_objects as go

_LINE = 80  # characters


@dataclass(frozen=True, eq=False)
class Tests:
    """Whether algorithms differ in an indicator; see `statistics` for the columns.

    Attributes
    ----------
    indicator : by which algorithms were compared.
    pairs : a row for each two of them.
    kruskal_wallis : whether there is any difference at all, None for fewer than three.

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


class Overview(pd.DataFrame):
    """A table whose text has all its columns, those that find no room below the others."""

    @property
    def _constructor(self) -> type[Overview]:
        return Overview

    def __repr__(self) -> str:
        return self.to_string(line_width=_LINE)


class Comparison(Results):
    """Measured runs of several algorithms on one problem, and what follows from them.

    Its text is the `overview`, after `n_eval` evaluations.

    Attributes
    ----------
    table : indicators of each algorithm and seed after each number of ``evaluations`` of the grid.
    runs : a row for each run: whether it finished, its wall time [s], its failures.
    records : the finished runs by (algorithm, seed).
    space : where the indicators were measured.

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

    def __repr__(self) -> str:
        name = type(self.problem).__name__
        return f"{name}, {self.n_eval:,} evaluations, mean ± sd\n{self.overview()!r}"

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
        samples = self.samples(indicator)
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
        titles = {each.name: each.title for each in [*self.indicators, *self.parts]}
        return Overview(columns, index=summary.index).rename(columns=titles)

    def to_latex(self) -> str:
        """The `overview` as a booktabs table and a note.

        The best mean by each indicator is bold, and what does not differ significantly from it is
        marked.
        """
        return problem_table(self).latex()

    def to_markdown(self) -> str:
        """The `overview` in Markdown, marked as `to_latex`."""
        return problem_table(self).markdown()

    def figures(self) -> dict[str, go.Figure]:
        """All figures that the number of objectives, algorithms and runs allows, by name."""
        from mgeo.studies.figures import comparison_figures

        return comparison_figures(self)


def _shown(mean: float, sd: float) -> str:
    """Mean ± sd, with as many digits as the sd (two of its own) makes sensible."""
    if not np.isfinite(mean):
        return "-" if np.isnan(mean) else str(mean)
    if not np.isfinite(sd) or sd == 0:
        return f"{mean:.6g}"
    exponent = int(f"{sd:.1e}".partition("e")[2])  # of the rounded value: 0.0999 is 0.10
    digits = min(max(1 - exponent, 0), 12)
    return f"{mean:.{digits}f} ± {sd:.{digits}f}"
