"""How far designs are from the limits of their scenario, each limit in its own unit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from mgeo_attitude._typing import Floats
from mgeo_attitude.criteria.constraints import Limit

if TYPE_CHECKING:
    import pandas as pd

#: Unit, value, "at most" or "at least", limit and margin.
Row = tuple[str, float, str, float, float]
_COLUMNS = ["unit", "value", "bound", "limit", "margin"]


def tables(
    limits: Sequence[Limit], excesses: Floats, after: Sequence[Mapping[str, Row]] | None = None
) -> list[pd.DataFrame]:
    """The table of each of n designs from what they exceed limits by, shape (n, n_limits).

    One row per limit, and then those that each design has `after` it has converged. Columns:
    ``unit``, ``value``, ``bound`` ("at most" or "at least"), ``limit``, and ``margin``, below zero
    where it is violated.
    """
    import pandas as pd

    more = [{} for _ in excesses] if after is None else after
    found = []
    for row, rest in zip(excesses, more, strict=True):
        cells = [_row(limit, each) for limit, each in zip(limits, row.tolist(), strict=True)]
        labels = [*(limit.label for limit in limits), *rest]
        index = pd.Index(labels, name="constraint", dtype=str)
        found.append(pd.DataFrame([*cells, *rest.values()], columns=_COLUMNS, index=index))
    return found


def _row(limit: Limit, excess: float) -> Row:
    bound = limit.bound * limit.factor
    value = bound * (1.0 - excess if limit.least else 1.0 + excess)
    return limit.unit, value, "at least" if limit.least else "at most", bound, -excess * bound
