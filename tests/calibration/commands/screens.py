"""Reading of printed tables."""

import re


def parse_table(text, title):
    """Return the rows of a printed table as lists of cells, by the first cell of the row."""
    lines = text.partition(f"\n{title}")[2].partition("\n\n")[0].splitlines()[1:]
    cells = [re.split(r"  +", line.strip()) for line in lines]
    return {row[0]: row[1:] for row in cells}
