"""Conclusions of comparisons and studies, as sentences and small tables."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import count

import numpy as np
import pandas as pd

from mgeo.studies.aggregation import (
    KEY_COLUMNS,
    compute_average_ranks,
    compute_problem_values,
)
from mgeo.studies.comparison import Comparison
from mgeo.studies.indicators import Indicator
from mgeo.studies.schema import PublishedTable
from mgeo.studies.statistics import SIGNIFICANCE_LEVEL, holm_correction
from mgeo.studies.study_file import Study


def format_conclusions(comparison: Comparison, control: str | None = None) -> list[str]:
    """Return sentences that name the best algorithm and compare it with the others.

    The first sentences describe the default indicator. Further sentences describe the other
    indicators, and the parts of the front on which the best algorithm is significantly worse.
    There are no sentences for fewer than two algorithms with finished runs.

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
        return []
    first, second = order[:2]
    is_control = first == control
    title = comparison.select_indicator().title
    rivals = compare_with_rivals(comparison, first, is_control=is_control)
    groups = {
        "significantly better than": rivals.index[rivals["result"] == "ahead"],
        "not significantly different from": rivals.index[rivals["result"] == "even"],
        "significantly worse than": rivals.index[rivals["result"] == "behind"],
    }
    differences = [f"{text} {join_names(names)}" for text, names in groups.items() if len(names)]
    sentences = [
        f"{first} ranks first by {title} (mean rank of its runs among all runs), followed by "
        f"{second}.",
        f"{first} is {'; '.join(differences)}.",
    ]
    significant, insignificant = [], []
    for indicator in comparison.indicators[1:]:
        best = comparison.rank_algorithms(indicator.name)[0]
        result = compare_with_rivals(comparison, first, indicator.name, is_control=is_control)
        if best != first:
            extent = "" if result.loc[best, "result"] == "behind" else "not "
            sentences.append(
                f"{best} ranks first by {indicator.title}, {extent}significantly better than "
                f"{first}."
            )
        elif result["result"].eq("ahead").all():
            significant.append(indicator.title)
        else:
            insignificant.append(indicator.title)
    if significant:
        sentences.append(
            f"{first} also ranks first by {join_names(significant)}, significantly better than "
            "every other algorithm."
        )
    if insignificant:
        sentences.append(f"{first} also ranks first by {join_names(insignificant)}.")
    for part in comparison.part_indicators:
        result = compare_with_rivals(comparison, first, part.name, is_control=is_control)
        names = result.index[result["result"] == "behind"]
        if len(names):
            sentences.append(
                f"By {part.title}, {first} is significantly worse than {join_names(names)}."
            )
    return sentences


def format_test_method(is_control: bool) -> str:
    """Return the name and correction of the test that compares two algorithms on a problem."""
    pairs = "the pairs of this algorithm" if is_control else "all pairs"
    return (
        f"Mann-Whitney test at {100 * SIGNIFICANCE_LEVEL:g} %, with Holm's correction for {pairs}"
    )


@dataclass(frozen=True, eq=False)
class StudySummary:
    """Comparison of one algorithm with every other algorithm, over all problems of a study.

    Attributes
    ----------
    algorithm : str
        Label of the algorithm: the control or, without a control, the algorithm of the best average
        rank.
    is_control : bool
        Whether the algorithm is the control of the study.
    ranks : DataFrame
        One row per algorithm, best first: ``average_rank`` of the median default indicator;
        ``best_on``, the number of problems on which the algorithm has the best median;
        ``better``, ``equal`` and ``worse``, the numbers of problems on which the algorithm of the
        row is significantly better than, not significantly different from, and significantly worse
        than `algorithm`; and ``p_holm`` of the signed-rank test over problems.
    pairs : DataFrame
        One row per problem and other algorithm: ``problem`` and ``algorithm``, with the columns of
        `compare_with_rivals`.
    conclusions : list of str
        Sentences, of which the first is the answer.
    n_functions : int
        Number of functions; instances and sizes of one function count once.
    """

    algorithm: str
    is_control: bool
    ranks: pd.DataFrame
    pairs: pd.DataFrame
    conclusions: list[str]
    n_functions: int


def summarize_study(
    comparisons: Mapping[str, Comparison], control: str | None = None
) -> StudySummary | None:
    """Compare the control, or else the best algorithm, with every other algorithm of a study.

    Parameters
    ----------
    comparisons : mapping of str to Comparison
        Finished comparisons by problem label.
    control : str, optional
        Label of the control algorithm, see `format_conclusions`.

    Returns
    -------
    StudySummary or None
        None for fewer than two algorithms with finished runs.
    """
    ranked = {label: c for label, c in comparisons.items() if len(c.rank_algorithms()) > 1}
    if not ranked:
        return None
    values = compute_problem_values(comparisons)
    last = values.loc[values.groupby("problem", sort=False)["evaluations"].idxmax()]
    medians = last.drop(columns=list(KEY_COLUMNS))
    # All problems are compared at the end of their budgets, whatever these are.
    ranks = compute_average_ranks(last.assign(variables=0, evaluations=0), control)
    ranks = ranks.set_index("algorithm")[["average_rank", "p_holm"]]
    is_control = any(control in c.rank_algorithms() for c in ranked.values())
    name = str(control if is_control else ranks.index[0])
    pairs = pd.concat(
        {
            label: compare_with_rivals(comparison, name, is_control=is_control)
            for label, comparison in ranked.items()
            if name in comparison.rank_algorithms()
        },
        names=["problem", "algorithm"],
    ).reset_index()
    counts = pd.crosstab(pairs["algorithm"], pairs["result"])
    # Results are those of `name`; a row of the ranks has those of the other algorithm.
    counts = counts.reindex(columns=["behind", "even", "ahead"], fill_value=0)
    counts = counts.set_axis(["better", "equal", "worse"], axis=1)
    ranks.insert(1, "best_on", medians.eq(medians.max(axis=1), axis=0).sum())
    ranks = ranks.join(counts)[["average_rank", "best_on", *counts, "p_holm"]]
    conclusions = _format_summary(comparisons, name, ranks, pairs)
    n_functions = last["function"].nunique()
    return StudySummary(name, is_control, ranks, pairs, conclusions, n_functions)


def _format_summary(
    comparisons: Mapping[str, Comparison], name: str, ranks: pd.DataFrame, pairs: pd.DataFrame
) -> list[str]:
    best = str(ranks.index[0])
    averages = {str(label): f"{rank:.2f}" for label, rank in ranks["average_rank"].items()}
    results = pairs.groupby("problem", sort=False)["result"].agg(set).to_dict()
    n_best = int(ranks["best_on"][name])
    ahead = [str(label) for label, found in results.items() if found == {"ahead"}]
    behind = [str(label) for label, found in results.items() if "behind" in found]
    sentences = [
        f"{name} has the {format_criterion(comparisons)} on {n_best} of "
        f"{len(comparisons)} problems.",
        f"Its average rank of {averages[name]} is the best of {len(ranks)} algorithms."
        if name == best
        else f"{best} has the best average rank: {averages[best]}, against {averages[name]} of "
        f"{name}.",
    ]
    if ahead:
        sentences.append(
            f"{name} is significantly better than every other algorithm on {len(ahead)} of "
            f"{len(comparisons)} problems: {join_names(ahead, 3)}."
        )
    if behind:
        sentences.append(
            f"{name} is significantly worse than at least one algorithm on {len(behind)}: "
            f"{join_names(behind)}."
        )
    else:
        sentences.append(f"No algorithm is significantly better than {name} on any problem.")
    return sentences


def list_warnings(comparisons: Mapping[str, Comparison], control: str | None = None) -> list[str]:
    """Return sentences about failed runs and other limitations of a study.

    A note that applies to several problems is returned once, with the labels of these problems.

    Parameters
    ----------
    comparisons : mapping of str to Comparison
        Finished comparisons by problem label.
    control : str, optional
        Label of the control algorithm, see `format_conclusions`.
    """
    labels_by_note: dict[str, list[str]] = {}
    for label, comparison in comparisons.items():
        for note in comparison.notes:
            labels_by_note.setdefault(note.removeprefix(f"{label}: "), []).append(label)
    failures = [text for label, c in comparisons.items() for text in c.describe_failures(label)]
    notes = [f"{join_names(labels)}: {note}" for note, labels in labels_by_note.items()]
    return [*notes, *failures, *_warn_of_few_seeds(comparisons, control)]


def _warn_of_few_seeds(comparisons: Mapping[str, Comparison], control: str | None) -> list[str]:
    """Return a sentence if there are too few seeds for a significant result on one problem."""
    n_seeds = min(c.table["seed"].nunique() for c in comparisons.values())
    n_algorithms = max(len(c.algorithms) for c in comparisons.values())
    if n_algorithms < 2 or (len(comparisons) > 1 and n_seeds == 1):
        return []  # Instances of functions may take the place of seeds.
    n_pairs = n_algorithms - 1 if control else math.comb(n_algorithms, 2)
    n_required = next(n for n in count(1) if _smallest_p(n, n_pairs) < SIGNIFICANCE_LEVEL)
    if n_seeds >= n_required:
        return []
    return [
        f"With {n_seeds} seed{'s' if n_seeds > 1 else ''} and {n_algorithms} algorithms, no "
        "difference on a single problem can be significant at "
        f"{100 * SIGNIFICANCE_LEVEL:g} %. Use at least {max(n_required, 10)} seeds."
    ]


def _smallest_p(n_seeds: int, n_pairs: int) -> float:
    """Return the smallest possible p value of the Mann-Whitney test, with Holm's correction."""
    return n_pairs * 2.0 / math.comb(2 * n_seeds, n_seeds)


def format_criterion(comparisons: Mapping[str, Comparison]) -> str:
    """Return the ranking criterion as text, such as "largest median hypervolume"."""
    indicators = {c.select_indicator().name: c.select_indicator() for c in comparisons.values()}
    if len(indicators) > 1:
        return "best median indicator"
    (indicator,) = indicators.values()
    return f"{'largest' if indicator.is_maximized else 'smallest'} median {indicator.title}"


def join_names(names: Iterable[str], n_max: int = 6) -> str:
    """Join names with commas and "and", and replace names beyond `n_max` with their number."""
    shown = list(map(str, names))
    if len(shown) > n_max:
        shown = [*shown[:n_max], f"{len(shown) - n_max} more"]
    return " and ".join([", ".join(shown[:-1]), shown[-1]] if len(shown) > 1 else shown)


def compare_with_rivals(
    comparison: Comparison, name: str, indicator: str | None = None, *, is_control: bool = False
) -> pd.DataFrame:
    """Compare one algorithm with every other algorithm by effect sizes and p values.

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
        is better than a run of the other; ``p_holm`` of the Mann-Whitney test with Holm's
        correction; and ``result``: "ahead" or "behind" if the algorithm is significantly better or
        worse, otherwise "even".

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
    result = np.select(
        [np.asarray(p) >= SIGNIFICANCE_LEVEL, effect > 0.5], ["even", "ahead"], "behind"
    )
    table = pd.DataFrame({"A": effect, "p_holm": p, "result": result})
    table.index = pd.Index(pairs["a"].where(is_second, pairs["b"]), name="other")
    return table.loc[[other for other in comparison.rank_algorithms(indicator) if other != name]]


def build_test_table(comparison: Comparison, control: str | None = None) -> pd.DataFrame:
    """Return the tests of all pairs of algorithms, for all indicators.

    Returns
    -------
    DataFrame
        ``indicator``, and the columns of `mgeo.studies.statistics.compare_pairwise`. With a
        control, ``p_holm_control`` is corrected for the pairs of the control only, see
        `compare_with_rivals`; it is NaN for other pairs.
    """
    tables = {}
    for indicator in comparison.all_indicators:
        pairs = comparison.test_differences(indicator.name).pairs
        if control is not None:
            is_own = (pairs[["a", "b"]] == control).any(axis=1)
            pairs.loc[is_own, "p_holm_control"] = holm_correction(pairs.loc[is_own, "p"])
        tables[indicator.name] = pairs
    return pd.concat(tables, names=["indicator"]).reset_index(0)


def format_control_table(
    comparison: Comparison, control: str, indicators: Sequence[Indicator]
) -> pd.DataFrame:
    """Format the effect sizes and p values of the control against the other algorithms.

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


def find_published_values(study: Study, comparison: Comparison) -> PublishedTable | None:
    """Return the published values, or None if they are for another number of evaluations."""
    published = study.published
    if published is None or published.evaluations not in (None, comparison.n_eval):
        return None
    return published


def format_published_table(study: Study, comparison: Comparison) -> pd.DataFrame | None:
    """Return a text table of published and measured indicator values, one row per algorithm.

    The last column is the measured default indicator.

    Returns
    -------
    DataFrame or None
        None if the study has no published values, or if the published runs had another number of
        evaluations.
    """
    published = find_published_values(study, comparison)
    if published is None:
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
