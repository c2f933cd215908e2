"""What a comparison found, and its tables for a paper, in Markdown and LaTeX.

There the best mean is bold, and what does not differ significantly from it is marked, which a note
below the table says.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from mgeo.studies.indicators import Indicator
from mgeo.studies.results import Results
from mgeo.studies.statistics import LEVEL, KruskalWallis, kruskal_wallis, pairwise

if TYPE_CHECKING:
    import plotly.graph_objects as go

_LINE = 80  # characters
_RIVALS = 5  # in figures: each adds up to 1 MB to a page
MARK = "†"

_LATEX = {
    "\\": r"\textbackslash{}",
    "±": r"$\pm$",
    "σ": r"$\sigma$",
    "τ": r"$\tau$",
    MARK: r"$^\dagger$",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
    "|": r"\textbar{}",
    **{character: f"\\{character}" for character in "&%$#_{}"},
}


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
        """All that can be drawn: anytime, boxes, fronts, each, attainment, difference.

        Fronts are drawn of two or three objectives, one by one and their attainment of two, if
        there are any. The difference is that of the best algorithm with a front and each of the
        five next.
        """
        from mgeo.studies.figures import fronts, indicators

        figures = {
            "anytime": indicators.anytime_figure(self),
            "boxes": indicators.boxes_figure(self),
        }
        ranked = [name for name in self.order() if any(map(len, self.fronts(name)))]
        if not ranked:
            return figures
        if self.problem.n_obj in (2, 3):
            figures["fronts"] = fronts.fronts_figure(self)
        if self.problem.n_obj == 2:
            figures["each"] = fronts.each_figure(self)
            figures["attainment"] = fronts.attainment_figure(self)
            if len(ranked) > 1:
                rivals = ranked[1 : _RIVALS + 1]
                figures["difference"] = fronts.difference_figure(self, ranked[0], rivals)
        return figures


def _shown(mean: float, sd: float) -> str:
    """Mean ± sd, with as many digits as the sd (two of its own) makes sensible."""
    if not np.isfinite(mean):
        return "-" if np.isnan(mean) else str(mean)
    if not np.isfinite(sd) or sd == 0:
        return f"{mean:.6g}"
    exponent = int(f"{sd:.1e}".partition("e")[2])  # of the rounded value: 0.0999 is 0.10
    digits = min(max(1 - exponent, 0), 12)
    return f"{mean:.{digits}f} ± {sd:.{digits}f}"


#: (row, column) of cells.
Cells = Collection[tuple[str, str]]


@dataclass(frozen=True, eq=False)
class MarkedTable:
    """A table of text, which of its cells are the `best`, which are `alike`, and what that means.

    Rows and columns have different names each.
    """

    table: pd.DataFrame
    best: Cells
    alike: Cells
    note: str

    def markdown(self) -> str:
        """As Markdown, with the note below."""
        text = markdown(_changed(self.table, self.best, self.alike, "**{}**"))
        return f"{text}\n{self.note}\n" if self.note else text

    def latex(self) -> str:
        """As a booktabs ``tabular``, with the note below, for a ``table`` environment."""
        text = latex(_changed(self.table, (), self.alike, ""), self.best)
        note = rf"\par\smallskip{{\footnotesize {escape(self.note)}}}"
        return f"{text}{note}\n" if self.note else text


def problem_table(comparison: Comparison) -> MarkedTable:
    """The `overview` of a comparison, each column of an indicator marked."""
    best, alike = [], []
    for indicator in [*comparison.indicators, *comparison.parts]:
        first, others = marks(comparison, indicator)
        best += [(name, indicator.title) for name in first]
        alike += [(name, indicator.title) for name in others]
    return MarkedTable(comparison.overview(), best, alike, _note(best))


def problems_table(comparisons: Mapping[str, Comparison]) -> MarkedTable:
    """Mean ± sd of each problem's first indicator, problems by algorithms, each row marked."""
    rows, best, alike = {}, [], []
    for label, comparison in comparisons.items():
        indicator = comparison.indicator()
        row = f"{label} ({indicator.title})"
        rows[row] = comparison.overview()[indicator.title]
        first, others = marks(comparison, indicator)
        best += [(row, name) for name in first]
        alike += [(row, name) for name in others]
    return MarkedTable(pd.DataFrame(rows).T.rename_axis("problem"), best, alike, _note(best))


def marks(comparison: Comparison, indicator: Indicator) -> tuple[list[str], list[str]]:
    """The algorithms with the best mean, and those that do not differ significantly from it.

    None where fewer than two have finished runs, or no mean is finite.
    """
    order = comparison.order(indicator.name)
    means = indicator.better(comparison.summary().loc[order, (indicator.name, "mean")])
    if len(order) < 2 or not np.isfinite(means.max()):
        return [], []
    best = [name for name in order if means[name] == means.max()]
    pairs = comparison.tests(indicator.name).pairs
    alike = pairs[(pairs[["a", "b"]] == best[0]).any(axis=1) & (pairs["p_holm"] >= LEVEL)]
    names = {str(name) for name in alike[["a", "b"]].to_numpy().ravel()}
    return best, [name for name in order if name in names and name not in best]


def markdown(table: pd.DataFrame) -> str:
    """A table with its index as the first column."""
    shown = table.rename_axis(str(table.index.name or "")).reset_index()
    lines = [[str(name) for name in shown], ["---", *["---:"] * len(table.columns)]]
    lines += shown.map(str).to_numpy().tolist()
    cells = [[cell.replace("|", r"\|") for cell in line] for line in lines]
    return "".join(f"| {' | '.join(line)} |\n" for line in cells)


def latex(table: pd.DataFrame, bold: Cells = ()) -> str:
    """A booktabs ``tabular`` with its index as the first column, some cells in bold."""
    cells = _changed(table.map(escape), bold, (), r"\textbf{{{}}}")
    shown = cells.rename(index=escape).rename_axis(str(table.index.name or "")).reset_index()
    columns = "l" + "r" * len(table.columns)
    text: str = shown.rename(columns=escape).to_latex(index=False, column_format=columns)
    return text


def escape(text: object) -> str:
    """Text that LaTeX prints as it stands."""
    return "".join(_LATEX.get(character, character) for character in str(text))


def _changed(table: pd.DataFrame, bold: Cells, marked: Cells, form: str) -> pd.DataFrame:
    cells = pd.DataFrame(table, dtype=object).copy()
    for row, column in bold:
        cells.at[row, column] = form.format(str(cells.at[row, column]))
    for row, column in marked:
        cells.at[row, column] = f"{cells.at[row, column]!s} {MARK}"
    return cells


def _note(best: Cells) -> str:
    return (
        f"Mean ± standard deviation of the runs. Bold: the best mean. {MARK}: does not differ "
        "significantly from it, by the Mann-Whitney test with Holm's correction for all pairs at "
        f"{100 * LEVEL:g} %."
        if best
        else ""
    )
