"""What a comparison says, in sentences and small tables."""

from __future__ import annotations

from collections.abc import Sequence

import pandas as pd

from mgeo.studies.comparison import Comparison
from mgeo.studies.file import Study
from mgeo.studies.indicators import Indicator
from mgeo.studies.statistics import LEVEL, holm


def conclusions(comparison: Comparison, control: str | None = None) -> list[str]:
    """Return sentences on the algorithm that ranks first, and from which others it differs.

    The first two sentences are about the first indicator, the others about where another indicator
    or a part of the front disagrees. There are none of them for fewer than two algorithms. The
    notes of the comparison are last.

    Parameters
    ----------
    control : the algorithm named before the results were seen, if any: p values of its pairs are
        corrected for its rivals alone, all others for all pairs; see `against`.
    """
    order = comparison.order()
    if len(order) < 2:
        return [*comparison.notes]
    first, second = order[:2]
    is_control = first == control
    title = comparison.indicator().title
    values = comparison.overview()[title]
    rivals = against(comparison, first, control=is_control)
    differs, is_ahead = rivals["p_holm"] < LEVEL, rivals["A"] > 0.5
    groups = {
        "significantly better than": rivals[differs & is_ahead],
        "significantly worse than": rivals[differs & ~is_ahead],
        "not significantly different from": rivals[~differs],
    }
    differences = [f"{words} {_names(rows)}" for words, rows in groups.items() if len(rows)]
    sentences = [
        f"By {title}, {first} ranks first: {values[first]}, then {second}: {values[second]}.",
        f"{first} is {'; '.join(differences)}. A is the probability that a run of {first} beats "
        "one of the other; Mann-Whitney test with Holm's correction for "
        f"{'its rivals' if is_control else 'all pairs'}, {100 * LEVEL:g} %.",
    ]
    for indicator in comparison.indicators[1:]:
        best = comparison.order(indicator.name)[0]
        sentence = f"By {indicator.title}, {best} ranks first"
        if best != first:
            rivals = against(comparison, first, indicator.name, control=is_control)
            effect, p = rivals.loc[best].to_numpy(float)
            sentence += f"; {first} against {best}: A = {effect:.2f}, p = {p:.2g}"
        sentences.append(f"{sentence}.")
    for part in comparison.parts:
        rivals = against(comparison, first, part.name, control=is_control)
        ahead = rivals[(rivals["p_holm"] < LEVEL) & (rivals["A"] < 0.5)]
        if len(ahead):
            sentences.append(
                f"By {part.title}, {first} is significantly worse than {_names(ahead)}."
            )
    return [*sentences, *comparison.notes]


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


def _names(rivals: pd.DataFrame) -> str:
    return ", ".join(f"{name} (A = {effect:.2f})" for name, effect in rivals["A"].items())


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
