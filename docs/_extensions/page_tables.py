"""Tables of executed pages, in the style of the tables that are written in Markdown."""

import pandas as pd
from IPython.display import Markdown


def show_table(table: pd.DataFrame, n_text_columns: int = 1) -> Markdown:
    """Return a table without its index. The first columns are left-aligned, all others
    right-aligned.
    """
    alignment = ["---"] * n_text_columns + ["---:"] * (table.shape[1] - n_text_columns)
    rows = [table.columns, alignment, *table.to_numpy()]
    return Markdown("\n".join(f"| {' | '.join(map(str, row))} |" for row in rows))
