"""How far designs are from the limits of their scenario, each limit in its own unit."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from mgeo_attitude._typing import Floats
from mgeo_attitude.constraints import Limit

if TYPE_CHECKING:
    import pandas as pd


def tables(limits: Sequence[Limit], excesses: Floats) -> list[pd.DataFrame]:
    """The table of each of n designs from what they exceed limits by, shape (n, n_limits).

    One row per limit. Columns: ``unit``, ``value``, ``bound`` ("at most" or "at least"), ``limit``,
    and ``margin``, below zero where it is violated.
    """
    import pandas as pd

    labels = pd.Index([limit.label for limit in limits], name="constraint", dtype=str)
    columns = ["unit", "value", "bound", "limit", "margin"]
    found = []
    for row in excesses:
        cells = []
        for limit, excess in zip(limits, row.tolist(), strict=True):
            bound = limit.bound * limit.factor
            value = bound * (1.0 - excess if limit.least else 1.0 + excess)
            least = "at least" if limit.least else "at most"
            cells.append((limit.unit, value, least, bound, -excess * bound))
        found.append(pd.DataFrame(cells, columns=columns, index=labels))
    return found
