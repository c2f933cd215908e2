"""What a comparison says, in sentences and small tables."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pandas as pd

from mgeo.studies.statistics import LEVEL, holm

if TYPE_CHECKING:
    from collections.abc import Sequence

    from mgeo.studies.comparison import Comparison
    from mgeo.studies.file import Study
    from mgeo.studies.indicators import Indicator


def conclusions(comparison: Comparison, control: str | None = None) -> list[str]:
    """Which algorithm ranks first by the first indicator, from which others it differs
    significantly and in what direction, and whether the other indicators and the number of points
    on a front agree.

    Parameters
    ----------
    control : the algorithm named before the results were seen, if any: p values of its pairs are
        corrected for its rivals alone, all others for all pairs; see `against`.
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
    named = first == control
    sentences.append(_differences(against(comparison, first, control=named), named))
    sentences += _other_indicators(comparison, first, control)
    if comparison.parts:
        sentences.append(_parts(comparison, first, named))
    if comparison.problem.n_obj > 1:
        sentences.append(_points(comparison, order))
    return sentences


def against(
    comparison: Comparison, name: str, indicator: str | None = None, *, control: bool = False
) -> pd.DataFrame:
    """One algorithm against every other one, in their order: A, the probability that a run of it
    beats one of the other, and ``p_holm`` of the Mann-Whitney test.

    Parameters
    ----------
    control : p is corrected for the rivals of this algorithm alone, not for all pairs; right for
        one that was named before the results were seen (Demsar 2006, section 3.2.2).

    Raises
    ------
    ValueError
        If the indicator is unknown.
    """
    pairs = comparison.tests(indicator).pairs
    pairs = pairs[(pairs[["a", "b"]] == name).any(axis=1)]
    second = pairs["b"] == name  # there A counts for the other one
    effect = pairs["A"].where(~second, 1.0 - pairs["A"])
    p = holm(pairs["p"]) if control else pairs["p_holm"]
    table = pd.DataFrame({"A": effect, "p_holm": p})
    table.index = pd.Index(pairs["a"].where(second, pairs["b"]), name="other")
    return table.loc[[other for other in comparison.order(indicator) if other != name]]


def control_table(
    comparison: Comparison, control: str, indicators: Sequence[Indicator]
) -> pd.DataFrame:
    """The control against each rival by each indicator, as text: A, and p corrected for its rivals.

    Rivals are in the order by the first indicator; see `against`. By the parts of the front it
    says where the control is ahead, and where behind.
    """
    columns: dict[str, pd.Series[str]] = {}
    for indicator in indicators:
        found = against(comparison, control, indicator.name, control=True)
        columns[f"{indicator.title}: A"] = found["A"].map("{:.3f}".format)
        columns[f"{indicator.title}: p (Holm)"] = found["p_holm"].map("{:.2g}".format)
    rivals = [name for name in comparison.order() if name != control]
    return pd.DataFrame(columns).loc[rivals].rename_axis(f"{control} against")


def _differences(rivals: pd.DataFrame, named: bool) -> str:
    differs, behind = rivals["p_holm"] < LEVEL, rivals["A"] > 0.5
    alike, worse, better = rivals[~differs], rivals[differs & behind], rivals[differs & ~behind]
    parts = []
    if len(alike):
        whom = _whom(alike, len(rivals), "any other")
        parts.append(f"it is not significantly different from {whom}")
    if len(worse):
        rest = "every other" if len(worse) == len(rivals) else "all others"
        parts.append(f"it is significantly better than {rest} ({_range(worse['A'])})")
    if len(better):
        parts.append(f"it is significantly worse than {_whom(better, len(rivals), 'every other')}")
    text = "; ".join(parts)
    return (
        f"{text[0].upper()}{text[1:]}. A is the probability that a run of it beats one of the "
        f"other; Mann-Whitney test with Holm's correction for {'its' if named else 'all'} "
        f"{'rivals' if named else 'pairs'}, {100 * LEVEL:g} %."
    )


def _whom(rivals: pd.DataFrame, count: int, everyone: str) -> str:
    if len(rivals) == count:
        return f"{everyone} ({_range(rivals['A'])})"
    return ", ".join(f"{name} (A = {a:.2f})" for name, a in rivals["A"].items())


def _range(values: pd.Series[float]) -> str:
    low, high = f"{values.min():.2f}", f"{values.max():.2f}"
    return f"A = {low}" if low == high else f"A from {low} to {high}"


def _other_indicators(comparison: Comparison, best: str, control: str | None) -> list[str]:
    sentences = []
    overview = comparison.overview()
    for indicator in comparison.indicators[1:]:
        order = comparison.order(indicator.name)
        first = order[0]
        if first == best:
            sentences.append(f"By {indicator.title}, {best} ranks first, too.")
            continue
        values = overview[indicator.title]
        one, other = (best, first) if best == control else (first, best)
        rivals = against(comparison, one, indicator.name, control=one == control)
        effect, p = rivals.loc[other].to_numpy(float)
        effect = effect if one == first else 1.0 - effect
        better, share = (first, effect) if effect > 0.5 else (best, 1.0 - effect)
        found = "these two are not significantly different"
        if p < LEVEL:
            found = f"{better} is significantly better (A = {share:.2f})"
        sentences.append(
            f"By {indicator.title}, {first} ranks first: {values[first]}, and {best} number "
            f"{order.index(best) + 1}: {values[best]}; {found}."
        )
    return sentences


def _parts(comparison: Comparison, first: str, named: bool) -> str:
    """Where on the front the first is behind: one number for a front does not tell."""
    behind = []
    for part in comparison.parts:
        rivals = against(comparison, first, part.name, control=named)
        ahead = rivals[(rivals["p_holm"] < LEVEL) & (rivals["A"] < 0.5)]
        behind += [f"{', '.join(ahead.index)} by {part.title}"] if len(ahead) else []
    if not behind:
        return f"In no part of the front is another one significantly better than {first}."
    return f"In a part of the front are significantly better than {first}: {'; '.join(behind)}."


def _points(comparison: Comparison, order: list[str]) -> str:
    means = comparison.summary()[("points", "mean")][order]
    most, highest = str(means.idxmax()), means.max()
    text = f"The most points are on the fronts of {most}: {highest:.0f} on average."
    if (place := order.index(most) + 1) == 1:
        return text
    return (
        f"{text} By {comparison.indicator().title} it is number {place} of {len(order)}: "
        "points say how finely a front was traced, not how far it reaches."
    )


def published_table(study: Study, comparison: Comparison) -> pd.DataFrame | None:
    """Published values and ours (mean ± sd) side by side, and ours of the first indicator.

    None without any, or where they are of another budget.
    """
    published = study.published
    if published is None or published.evaluations not in (None, comparison.n_eval):
        return None
    overview = comparison.overview()
    titles = {indicator.name: indicator.title for indicator in comparison.indicators}
    columns: dict[str, list[str]] = {}
    for name in dict.fromkeys(key for row in published.table.values() for key in row):
        values = [published.table.get(label, {}).get(name) for label in overview.index]
        columns[f"{name}: published"] = ["-" if v is None else f"{v:.12g}" for v in values]
        if titles.get(name, name) in overview:
            columns[f"{name}: here"] = overview[titles.get(name, name)].tolist()
    first = comparison.indicator().title
    columns[f"{first}: here"] = overview[first].tolist()
    return pd.DataFrame(columns, index=overview.index)
