"""Tables as Markdown and LaTeX."""

from __future__ import annotations

from collections.abc import Collection

import pandas as pd

_LATEX = {
    "\\": r"\textbackslash{}",
    "±": r"$\pm$",
    "σ": r"$\sigma$",
    "τ": r"$\tau$",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    **{character: f"\\{character}" for character in "&%$#_{}"},
}


def markdown(table: pd.DataFrame) -> str:
    """A table with its index as the first column."""
    shown = table.rename_axis(str(table.index.name or "")).reset_index()
    lines = [[str(name) for name in shown], ["---", *["---:"] * len(table.columns)]]
    lines += shown.map(str).to_numpy().tolist()
    cells = [[cell.replace("|", r"\|") for cell in line] for line in lines]
    return "".join(f"| {' | '.join(line)} |\n" for line in cells)


def latex(table: pd.DataFrame, bold: Collection[tuple[str, str]] = ()) -> str:
    """A booktabs ``tabular`` with its index as the first column.

    Parameters
    ----------
    bold : (row, column) of the cells to set in bold.
    """
    cells = table.map(escape)
    for row, column in bold:
        cells.at[row, column] = rf"\textbf{{{cells.at[row, column]!s}}}"
    shown = cells.rename(index=escape).rename_axis(str(table.index.name or "")).reset_index()
    columns = "l" + "r" * len(table.columns)
    text: str = shown.rename(columns=escape).to_latex(index=False, column_format=columns)
    return text


def escape(text: object) -> str:
    """Text that LaTeX prints as it stands."""
    return "".join(_LATEX.get(character, character) for character in str(text))
