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
    f"Mean ± standard deviation of the runs. Bold: the best mean. {EQUIVALENCE_MARK}: does not differ "
    "significantly from it, by the Mann-Whitney test with Holm's correction for all pairs at "
    f"{100 * SIGNIFICANCE_LEVEL:g} %."
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

#: Cells by (row, column).
Cells = Collection[tuple[str, str]]


@dataclass(frozen=True, eq=False)
class MarkedTable:
    """Table of text in which the `best` cells are bold and the `equivalent` cells are marked.

    Row names and column names are unique.
    """

    table: pd.DataFrame
    best: Cells
    equivalent: Cells

    @property
    def note(self) -> str:
        """Explanation of the marks; empty if no cell is marked."""
        return _NOTE if self.best else ""

    def to_markdown(self) -> str:
        """Return the table in Markdown, followed by the note."""
        text = format_markdown(self._mark_cells("**{}**", str))
        return f"{text}\n{self.note}\n" if self.note else text

    def to_latex(self) -> str:
        """Return a booktabs ``tabular`` and the note, for use in a ``table`` environment."""
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
    """Return the `overview` of a comparison with marks in each indicator column."""
    best, alike = [], []
    for indicator in comparison.all_indicators:
        first, equivalent = find_best_and_equivalent(comparison, indicator)
        best += [(name, indicator.title) for name in first]
        alike += [(name, indicator.title) for name in equivalent]
    return MarkedTable(comparison.format_overview(), best, alike)


def build_study_table(comparisons: Mapping[str, Comparison]) -> MarkedTable:
    """Return mean ± sd of the first indicator, problems in rows, with marks in each row."""
    rows, best, alike = {}, [], []
    for label, comparison in comparisons.items():
        indicator = comparison.select_indicator()
        row = f"{label} ({indicator.title})"
        rows[row] = comparison.format_overview()[indicator.title]
        first, equivalent = find_best_and_equivalent(comparison, indicator)
        best += [(row, name) for name in first]
        alike += [(row, name) for name in equivalent]
    return MarkedTable(pd.DataFrame(rows).T.rename_axis("problem"), best, alike)


def find_best_and_equivalent(
    comparison: Comparison, indicator: Indicator
) -> tuple[list[str], list[str]]:
    """Return the algorithms with the best mean, and those without a significant difference from it.

    Both lists are empty if fewer than two algorithms have finished runs, or no mean is finite.
    """
    order = comparison.rank_algorithms(indicator.name)
    means = indicator.negate_if_minimized(
        comparison.summarize().loc[order, (indicator.name, "mean")]
    )
    if len(order) < 2 or not np.isfinite(means.max()):
        return [], []
    best = [name for name in order if means[name] == means.max()]
    pairs = comparison.test_differences(indicator.name).pairs
    alike = pairs[
        (pairs[["a", "b"]] == best[0]).any(axis=1) & (pairs["p_holm"] >= SIGNIFICANCE_LEVEL)
    ]
    names = {str(name) for name in alike[["a", "b"]].to_numpy().ravel()}
    return best, [name for name in order if name in names and name not in best]


def format_markdown(table: pd.DataFrame) -> str:
    """Return a table in Markdown, with the index as the first column."""
    shown = table.rename_axis(str(table.index.name or "")).reset_index()
    lines = [[str(name) for name in shown], ["---", *["---:"] * len(table.columns)]]
    lines += shown.map(str).to_numpy().tolist()
    cells = [[cell.replace("|", r"\|") for cell in line] for line in lines]
    return "".join(f"| {' | '.join(line)} |\n" for line in cells)


def escape_latex(text: object) -> str:
    """Escape the characters of a text that LaTeX would interpret."""
    return "".join(_LATEX_ESCAPES.get(character, character) for character in str(text))
