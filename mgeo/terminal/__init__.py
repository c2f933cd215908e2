"""Text for terminals, pipes and logs: consoles, what may be printed on them, and tables.

Commands, those of plugins too, and the progress of studies write through it.
"""

from mgeo.terminal.consoles import (
    broken,
    console,
    is_terminal,
    plain,
    printable,
    write_anything,
)
from mgeo.terminal.tables import Columns, pairs, table

__all__ = [
    "Columns",
    "broken",
    "console",
    "is_terminal",
    "pairs",
    "plain",
    "printable",
    "table",
    "write_anything",
]
