"""What a comparison says, in sentences and small tables."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pandas as pd

if TYPE_CHECKING:
    from mgeo.studies.comparison import Comparison
    from mgeo.studies.file import Published

_LEVEL = 0.05


def verdict(comparison: Comparison) -> list[str]:
    """Which algorithm is best by the first indicator, from which it cannot be told apart, and
    whether the number of points on a front says the same.
    """
    order = comparison.order()
    if len(order) < 2:
        return []
    best, *others = order
    title = comparison.indicator().title
    overview = comparison.overview()
    tests = comparison.tests()
    pairs = tests.pairs[(tests.pairs[["a", "b"]] == best).any(axis=1)]
    alike = pairs[pairs["p_holm"] >= _LEVEL]
    rivals = [b if a == best else a for a, b in zip(alike["a"], alike["b"], strict=True)]
    values = overview[comparison.indicator().name].tolist()
    first, second = (values[comparison.algorithms.index(name)] for name in order[:2])
    sentences = [f"By {title}, {best} is the best: {first}, then {others[0]}: {second}."]
    if len(rivals) == len(others):
        found = "The runs do not tell it apart from any other"
    elif rivals:
        found = f"The runs do not tell it apart from {', '.join(rivals)}"
    else:
        found = "It differs from every other"
    sentences.append(f"{found} (Mann-Whitney with Holm's correction, 5 %).")
    return [*sentences, *_points(comparison, order)]


def _points(comparison: Comparison, order: list[str]) -> list[str]:
    final = comparison.final()
    means = final.groupby("algorithm", sort=False)[["points"]].mean()["points"][order]
    most = str(means.idxmax())
    text = f"The most points are on the fronts of {most}: {means.max():.0f} on average."
    place = order.index(most) + 1
    if place > 1:
        text += (
            f" By {comparison.indicator().title} it is number {place} of {len(order)}: "
            "points say how finely a front was traced, not how far it reaches."
        )
    return [text]


def beside(comparison: Comparison, published: Published) -> pd.DataFrame:
    """Published values and ours (mean ± sd) side by side, and ours of the first indicator."""
    overview = comparison.overview()
    columns: dict[str, list[str]] = {}
    for name in dict.fromkeys(key for row in published.table.values() for key in row):
        rows = [published.table.get(label, {}) for label in overview.index]
        columns[f"{name}: published"] = [str(row.get(name, "-")) for row in rows]
        if name in overview:
            columns[f"{name}: here"] = overview[name].tolist()
    first = comparison.indicator()
    columns[f"{first.title}: here"] = overview[first.name].tolist()
    return pd.DataFrame(columns, index=overview.index)
