"""What a comparison says, in sentences and small tables."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pandas as pd

if TYPE_CHECKING:
    from mgeo.studies.comparison import Comparison
    from mgeo.studies.schema import PublishedTable

_LEVEL = 0.05


def conclusions(comparison: Comparison) -> list[str]:
    """Which algorithm ranks first by the first indicator, from which others it differs
    significantly and in what direction, and whether the other indicators and the number of points
    on a front agree.
    """
    order = comparison.order()
    if len(order) < 2:
        return []
    first, second = order[:2]
    indicator = comparison.indicator()
    values = comparison.overview()[indicator.title]
    means = indicator.better(comparison.summary()[(indicator.name, "mean")])
    sentences = [
        f"By {indicator.title}, {first} ranks first: {values[first]}, then {second}: "
        f"{values[second]}."
    ]
    if means.max() > means[first]:
        highest = str(means.idxmax())
        sentences.append(
            f"The best mean is that of {highest}, {values[highest]}; ranks say how often a run is "
            "better, means also by how much."
        )
    sentences.append(_differences(against(comparison, first)))
    sentences += _other_indicators(comparison, first)
    if comparison.problem.n_obj > 1:
        sentences += _points(comparison, order)
    return sentences


def against(comparison: Comparison, name: str, indicator: str | None = None) -> pd.DataFrame:
    """One algorithm against every other one, in their order: A, the probability that a run of it
    beats one of the other, and ``p_holm`` of the Mann-Whitney test.

    Raises
    ------
    ValueError
        If the indicator is unknown.
    """
    pairs = comparison.tests(indicator).pairs
    pairs = pairs[(pairs[["a", "b"]] == name).any(axis=1)]
    second = pairs["b"] == name  # there A counts for the other one
    effect = pairs["A"].where(~second, 1.0 - pairs["A"])
    table = pd.DataFrame({"A": effect, "p_holm": pairs["p_holm"]})
    table.index = pd.Index(pairs["a"].where(second, pairs["b"]), name="other")
    return table.loc[[other for other in comparison.order(indicator) if other != name]]


def _differences(rivals: pd.DataFrame) -> str:
    differs = rivals["p_holm"] < _LEVEL
    alike = rivals[~differs]
    worse, better = (rivals[differs & side] for side in (rivals["A"] > 0.5, rivals["A"] <= 0.5))
    parts = []
    if len(alike):
        whom = _whom(alike, len(rivals), "any other")
        parts.append(f"it is not significantly different from {whom}")
    if len(worse):
        rest = "all others" if len(alike) or len(better) else "every other"
        parts.append(f"it is significantly better than {rest} ({_range(worse['A'])})")
    if len(better):
        parts.append(f"it is significantly worse than {_whom(better, len(rivals), 'every other')}")
    text = "; ".join(parts)
    return (
        f"{text[0].upper()}{text[1:]}. A is the probability that a run of it beats one of the "
        f"other; Mann-Whitney test with Holm's correction, {100 * _LEVEL:g} %."
    )


def _whom(rivals: pd.DataFrame, count: int, everyone: str) -> str:
    if len(rivals) == count:
        return f"{everyone} ({_range(rivals['A'])})"
    return ", ".join(f"{name} (A = {a:.2f})" for name, a in rivals["A"].items())


def _range(values: pd.Series[float]) -> str:
    low, high = f"{values.min():.2f}", f"{values.max():.2f}"
    return f"A = {low}" if low == high else f"A from {low} to {high}"


def _other_indicators(comparison: Comparison, best: str) -> list[str]:
    sentences = []
    overview = comparison.overview()
    for indicator in comparison.indicators[1:]:
        order = comparison.order(indicator.name)
        first = order[0]
        if first == best:
            sentences.append(f"By {indicator.title}, {best} ranks first, too.")
            continue
        values = overview[indicator.title]
        effect, p = against(comparison, first, indicator.name).loc[best].to_numpy(float)
        better, share = (first, effect) if effect > 0.5 else (best, 1.0 - effect)
        found = "these two are not significantly different"
        if p < _LEVEL:
            found = f"{better} is significantly better (A = {share:.2f})"
        sentences.append(
            f"By {indicator.title}, {first} ranks first: {values[first]}, and {best} number "
            f"{order.index(best) + 1}: {values[best]}; {found}."
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


def comparison_with_published(comparison: Comparison, published: PublishedTable) -> pd.DataFrame:
    """Published values and ours (mean ± sd) side by side, and ours of the first indicator."""
    overview = comparison.overview()
    titles = {indicator.name: indicator.title for indicator in comparison.indicators}
    columns: dict[str, list[str]] = {}
    for name in dict.fromkeys(key for row in published.table.values() for key in row):
        rows = [published.table.get(label, {}) for label in overview.index]
        columns[f"{name}: published"] = [
            f"{row[name]:.12g}" if name in row else "-" for row in rows
        ]
        if titles.get(name, name) in overview:
            columns[f"{name}: here"] = overview[titles.get(name, name)].tolist()
    first = comparison.indicator()
    columns[f"{first.title}: here"] = overview[first.title].tolist()
    return pd.DataFrame(columns, index=overview.index)
