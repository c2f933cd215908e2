"""Tables as Markdown and LaTeX."""

from __future__ import annotations

from collections.abc import Collection, Iterable

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
    header = [str(table.index.name or ""), *map(str, table.columns)]
    rows = [
        [str(name), *map(str, row)] for name, row in zip(table.index, _rows(table), strict=True)
    ]
    lines = [header, ["---", *["---:"] * len(table.columns)], *rows]
    cells = [[cell.replace("|", r"\|") for cell in line] for line in lines]
    return "".join(f"| {' | '.join(line)} |\n" for line in cells)


def latex(table: pd.DataFrame, bold: Collection[tuple[str, str]] = ()) -> str:
    """A booktabs ``tabular`` with its index as the first column.

    Parameters
    ----------
    bold : (row, column) of the cells to set in bold.
    """
    names = [str(name) for name in table.columns]
    header = [str(table.index.name or ""), *names]
    lines = [rf"\begin{{tabular}}{{l{'r' * len(names)}}}", r"\toprule", _row(map(escape, header))]
    lines.append(r"\midrule")
    for index, row in zip(table.index, _rows(table), strict=True):
        cells = [escape(str(index))]
        for name, value in zip(names, row, strict=True):
            text = escape(str(value))
            cells.append(rf"\textbf{{{text}}}" if (index, name) in bold else text)
        lines.append(_row(cells))
    return "\n".join([*lines, r"\bottomrule", r"\end{tabular}", ""])


def escape(text: str) -> str:
    """Text that LaTeX prints as it stands."""
    return "".join(_LATEX.get(character, character) for character in text)


def _rows(table: pd.DataFrame) -> list[list[object]]:
    return table.astype(object).to_numpy().tolist()


def _row(cells: Iterable[str]) -> str:
    return " & ".join(cells) + r" \\"
