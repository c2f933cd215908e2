"""Conclusions of a comparison, as sentences and small tables for report pages."""

from __future__ import annotations

from collections.abc import Sequence

import pandas as pd

from mgeo.studies.comparison import Comparison
from mgeo.studies.indicators import Indicator
from mgeo.studies.statistics import SIGNIFICANCE_LEVEL, holm_correction
from mgeo.studies.study_file import Study


def format_conclusions(comparison: Comparison, control: str | None = None) -> list[str]:
    """Return sentences that name the best algorithm and compare it with every other algorithm.

    Two sentences describe the default indicator. Further sentences describe the other indicators,
    and the parts of the front where the best algorithm is significantly worse. The notes of the
    comparison come last; with fewer than two algorithms, only the notes are returned.

    Parameters
    ----------
    comparison : Comparison
        Finished comparison.
    control : str, optional
        Label of the control algorithm, chosen before the results were available. If the control
        ranks first, its p values are corrected for its own pairs; otherwise, p values are corrected
        for all pairs.

    Returns
    -------
    list of str
    """
    order = comparison.rank_algorithms()
    if len(order) < 2:
        return [*comparison.notes]
    first, second = order[:2]
    is_control = first == control
    title = comparison.select_indicator().title
    values = comparison.format_overview()[title]
    rivals = compare_with_rivals(comparison, first, is_control=is_control)
    is_different, is_better = rivals["p_holm"] < SIGNIFICANCE_LEVEL, rivals["A"] > 0.5
    groups = {
        "significantly better than": rivals[is_different & is_better],
        "significantly worse than": rivals[is_different & ~is_better],
        "not significantly different from": rivals[~is_different],
    }
    differences = [f"{text} {_format_rivals(rows)}" for text, rows in groups.items() if len(rows)]
    sentences = [
        f"By {title}, {first} ranks first: {values[first]}, then {second}: {values[second]}.",
        f"{first} is {'; '.join(differences)}. A is the probability that a run of {first} beats "
        "a run of the other algorithm; Mann-Whitney test with Holm's correction for "
        f"{'its own pairs' if is_control else 'all pairs'}, {100 * SIGNIFICANCE_LEVEL:g} %.",
    ]
    for indicator in comparison.indicators[1:]:
        best = comparison.rank_algorithms(indicator.name)[0]
        sentence = f"By {indicator.title}, {best} ranks first"
        if best != first:
            rivals = compare_with_rivals(comparison, first, indicator.name, is_control=is_control)
            effect, p = rivals.loc[best].to_numpy(float)
            sentence += f"; {first} against {best}: A = {effect:.2f}, p = {p:.2g}"
        sentences.append(f"{sentence}.")
    for part in comparison.part_indicators:
        rivals = compare_with_rivals(comparison, first, part.name, is_control=is_control)
        better = rivals[(rivals["p_holm"] < SIGNIFICANCE_LEVEL) & (rivals["A"] < 0.5)]
        if len(better):
            sentences.append(
                f"By {part.title}, {first} is significantly worse than {_format_rivals(better)}."
            )
    return [*sentences, *comparison.notes]


def compare_with_rivals(
    comparison: Comparison, name: str, indicator: str | None = None, *, is_control: bool = False
) -> pd.DataFrame:
    """Return a table of effect sizes and p values of one algorithm against every other algorithm.

    Parameters
    ----------
    comparison : Comparison
        Finished comparison.
    name : str
        Label of the algorithm.
    indicator : str, optional
        Name of the indicator. Default: the first of `indicators`.
    is_control : bool
        Whether to correct p values only for the pairs of this algorithm. This is valid for an
        algorithm chosen before the results were available (Demsar 2006, section 3.2.2).

    Returns
    -------
    DataFrame
        One row per other algorithm, best first: ``A``, the probability that a run of the algorithm
        beats a run of the other, and ``p_holm`` of the Mann-Whitney test with Holm's correction.

    Raises
    ------
    ValueError
        If the indicator is unknown.
    """
    pairs = comparison.test_differences(indicator).pairs
    pairs = pairs[(pairs[["a", "b"]] == name).any(axis=1)]
    is_second = pairs["b"] == name  # In these rows, A is the probability that the rival wins.
    effect = pairs["A"].where(~is_second, 1.0 - pairs["A"])
    p = holm_correction(pairs["p"]) if is_control else pairs["p_holm"]
    table = pd.DataFrame({"A": effect, "p_holm": p})
    table.index = pd.Index(pairs["a"].where(is_second, pairs["b"]), name="other")
    return table.loc[[other for other in comparison.rank_algorithms(indicator) if other != name]]


def format_control_table(
    comparison: Comparison, control: str, indicators: Sequence[Indicator]
) -> pd.DataFrame:
    """Format the effect sizes and p values of the control against every other algorithm as a table.

    There are two columns per indicator. The other algorithms are sorted by the default indicator.
    p values are corrected for the pairs of the control, see `compare_with_rivals`.
    """
    columns: dict[str, pd.Series[str]] = {}
    for indicator in indicators:
        rivals_table = compare_with_rivals(comparison, control, indicator.name, is_control=True)
        columns[f"{indicator.title}: A"] = rivals_table["A"].map("{:.3f}".format)
        columns[f"{indicator.title}: p (Holm)"] = rivals_table["p_holm"].map("{:.2g}".format)
    rivals = [name for name in comparison.rank_algorithms() if name != control]
    return pd.DataFrame(columns).loc[rivals].rename_axis(f"{control} against")


def _format_rivals(rivals: pd.DataFrame) -> str:
    return ", ".join(f"{name} (A = {effect:.2f})" for name, effect in rivals["A"].items())


def format_published_table(study: Study, comparison: Comparison) -> pd.DataFrame | None:
    """Return a text table with one row per algorithm, which shows published indicator values beside
    the measured mean ± standard deviation.

    The last column is the measured default indicator.

    Returns
    -------
    DataFrame or None
        None if the study has no published values, or if the published runs had another number of
        evaluations.
    """
    published = study.published
    if published is None or published.evaluations not in (None, comparison.n_eval):
        return None
    overview = comparison.format_overview()
    titles = {indicator.name: indicator.title for indicator in comparison.indicators}
    columns: dict[str, list[str]] = {}
    for name in dict.fromkeys(key for row in published.table.values() for key in row):
        values = [published.table.get(label, {}).get(name) for label in overview.index]
        columns[f"{name}: published"] = ["-" if v is None else f"{v:.12g}" for v in values]
        if titles.get(name, name) in overview:
            columns[f"{name}: measured"] = overview[titles.get(name, name)].tolist()
    first = comparison.select_indicator().title
    columns[f"{first}: measured"] = overview[first].tolist()
    return pd.DataFrame(columns, index=overview.index)
