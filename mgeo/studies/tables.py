"""Tables of a comparison for publications, in Markdown and LaTeX.

The best mean is bold, and values without a significant difference from the best are marked.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from mgeo.studies.indicators import Indicator
from mgeo.studies.statistics import SIGNIFICANCE_LEVEL

if TYPE_CHECKING:
    from mgeo.studies.comparison import Comparison

EQUIVALENCE_MARK = "†"

_NOTE = (
    "Mean ± standard deviation of the runs. Bold: the best mean. "
    f"{EQUIVALENCE_MARK}: no significant difference from the best, by the Mann-Whitney test with "
    f"Holm's correction for all pairs at {100 * SIGNIFICANCE_LEVEL:g} %."
)

_LATEX_ESCAPES = {
    "\\": r"\textbackslash{}",
    "±": r"$\pm$",
    "σ": r"$\sigma$",
    "τ": r"$\tau$",
    EQUIVALENCE_MARK: r"$^\dagger$",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
    "|": r"\textbar{}",
    **{character: f"\\{character}" for character in "&%$#_{}"},
}

#: Row and column name of each cell.
Cells = Collection[tuple[str, str]]


@dataclass(frozen=True, eq=False)
class MarkedTable:
    """Text table that marks the best values and those that do not differ significantly from the
    best.

    Row names and column names are unique.

    Attributes
    ----------
    table : DataFrame
        Texts of the cells.
    best : collection of (str, str)
        Cells, by row and column, that are shown in bold.
    equivalent : collection of (str, str)
        Cells without a significant difference from the best, which are shown with a mark.
    """

    table: pd.DataFrame
    best: Cells
    equivalent: Cells

    @property
    def note(self) -> str:
        """Text that explains the marks, or an empty string if no cell is marked."""
        return _NOTE if self.best else ""

    def to_markdown(self) -> str:
        """Return the table in Markdown, followed by the note."""
        text = format_markdown(self._mark_cells("**{}**", str))
        return f"{text}\n{self.note}\n" if self.note else text

    def to_latex(self) -> str:
        """Return the table as a LaTeX ``tabular`` with booktabs rules, followed by the note.

        The text is for use in a LaTeX ``table`` environment.
        """
        cells = self._mark_cells(r"\textbf{{{}}}", escape_latex).rename(
            index=escape_latex, columns=escape_latex
        )
        cells = cells.rename_axis(escape_latex(cells.index.name or "")).reset_index()
        columns = "l" + "r" * len(self.table.columns)
        text: str = cells.to_latex(index=False, column_format=columns)
        note = rf"\par\smallskip{{\footnotesize {escape_latex(self.note)}}}"
        return f"{text}{note}\n" if self.note else text

    def _mark_cells(self, bold: str, escape_text: Callable[[object], str]) -> pd.DataFrame:
        cells = self.table.map(escape_text)
        for row, column in self.best:
            cells.at[row, column] = bold.format(cells.at[row, column])
        for row, column in self.equivalent:
            cells.at[row, column] = f"{cells.at[row, column]!s} {escape_text(EQUIVALENCE_MARK)}"
        return cells


def build_problem_table(comparison: Comparison) -> MarkedTable:
    """Build a table of the mean ± standard deviation of each indicator, one row per algorithm."""
    best, equivalent = [], []
    for indicator in comparison.all_indicators:
        winners, similar = find_best_and_equivalent(comparison, indicator)
        best += [(name, indicator.title) for name in winners]
        equivalent += [(name, indicator.title) for name in similar]
    return MarkedTable(comparison.format_overview(), best, equivalent)


def build_study_table(comparisons: Mapping[str, Comparison]) -> MarkedTable:
    """Build a table of the mean ± standard deviation of the default indicator on each problem.

    The best algorithms are marked in each row.
    """
    rows, best, equivalent = {}, [], []
    for label, comparison in comparisons.items():
        indicator = comparison.select_indicator()
        row = f"{label} ({indicator.title})"
        rows[row] = comparison.format_overview()[indicator.title]
        winners, similar = find_best_and_equivalent(comparison, indicator)
        best += [(row, name) for name in winners]
        equivalent += [(row, name) for name in similar]
    return MarkedTable(pd.DataFrame(rows).T.rename_axis("problem"), best, equivalent)


def find_best_and_equivalent(
    comparison: Comparison, indicator: Indicator
) -> tuple[list[str], list[str]]:
    """Return the algorithms with the best mean, and those that do not differ from it significantly.

    Returns
    -------
    best, equivalent : list of str
        Labels. Both lists are empty if fewer than two algorithms have finished runs, or no mean is
        finite.
    """
    order = comparison.rank_algorithms(indicator.name)
    means = indicator.negate_if_minimized(
        comparison.summarize().loc[order, (indicator.name, "mean")]
    )
    if len(order) < 2 or not np.isfinite(means.max()):
        return [], []
    best = [name for name in order if means[name] == means.max()]
    pairs = comparison.test_differences(indicator.name).pairs
    similar = pairs[
        (pairs[["a", "b"]] == best[0]).any(axis=1) & (pairs["p_holm"] >= SIGNIFICANCE_LEVEL)
    ]
    names = {str(name) for name in similar[["a", "b"]].to_numpy().ravel()}
    return best, [name for name in order if name in names and name not in best]


def format_markdown(table: pd.DataFrame) -> str:
    """Convert a table to Markdown, with the index as the first column."""
    columns = table.rename_axis(str(table.index.name or "")).reset_index()
    lines = [[str(name) for name in columns], ["---", *["---:"] * len(table.columns)]]
    lines += columns.map(str).to_numpy().tolist()
    cells = [[cell.replace("|", r"\|") for cell in line] for line in lines]
    return "".join(f"| {' | '.join(line)} |\n" for line in cells)


def escape_latex(text: object) -> str:
    return "".join(_LATEX_ESCAPES.get(character, character) for character in str(text))
