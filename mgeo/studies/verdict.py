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
    whether the other indicators and the number of points on a front say the same.
    """
    order = comparison.order()
    if len(order) < 2:
        return []
    best, second = order[:2]
    title = comparison.indicator().title
    values = comparison.overview()[title]
    rivals = _not_told_apart(comparison, best)
    if len(rivals) == len(order) - 1:
        found = "The runs do not tell it apart from any other"
    elif rivals:
        found = f"The runs do not tell it apart from {', '.join(rivals)}"
    else:
        found = "It differs from every other"
    return [
        f"By {title}, {best} is the best: {values[best]}, then {second}: {values[second]}.",
        f"{found} (Mann-Whitney with Holm's correction, {100 * _LEVEL:g} %).",
        *_other_indicators(comparison, best),
        *_points(comparison, order),
    ]


def _not_told_apart(comparison: Comparison, name: str, indicator: str | None = None) -> list[str]:
    pairs = comparison.tests(indicator).pairs
    alike = pairs[(pairs[["a", "b"]] == name).any(axis=1) & (pairs["p_holm"] >= _LEVEL)]
    return [b if a == name else a for a, b in zip(alike["a"], alike["b"], strict=True)]


def _other_indicators(comparison: Comparison, best: str) -> list[str]:
    sentences = []
    overview = comparison.overview()
    for indicator in comparison.indicators[1:]:
        order = comparison.order(indicator.name)
        first = order[0]
        if first == best:
            sentences.append(f"By {indicator.title}, {best} is the best, too.")
            continue
        values = overview[indicator.title]
        alike = first in _not_told_apart(comparison, best, indicator.name)
        sentences.append(
            f"By {indicator.title}, {first} is the best: {values[first]}, and {best} number "
            f"{order.index(best) + 1}: {values[best]}; the runs "
            f"{'do not tell' if alike else 'tell'} these two apart."
        )
    return sentences


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
    titles = {indicator.name: indicator.title for indicator in comparison.indicators}
    columns: dict[str, list[str]] = {}
    for name in dict.fromkeys(key for row in published.table.values() for key in row):
        rows = [published.table.get(label, {}) for label in overview.index]
        columns[f"{name}: published"] = [str(row.get(name, "-")) for row in rows]
        if titles.get(name, name) in overview:
            columns[f"{name}: here"] = overview[titles.get(name, name)].tolist()
    first = comparison.indicator()
    columns[f"{first.title}: here"] = overview[first.title].tolist()
    return pd.DataFrame(columns, index=overview.index)
