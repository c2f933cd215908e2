"""Tables of the results of a study, which the terminal and the report pages share."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from mgeo.plugins.review import Section
from mgeo.studies.comparison import Comparison
from mgeo.studies.conclusions import (
    StudySummary,
    find_published_values,
    format_criterion,
    format_test_method,
)
from mgeo.studies.statistics import SIGNIFICANCE_LEVEL
from mgeo.studies.study_file import Study

_ZERO_HYPERVOLUME = "Hypervolume 0: no point of the front dominates the reference point."
_MAX_BUDGETS = 5  # maximum number of rows of `build_budget_table` for each number of variables


def build_rank_table(comparisons: Mapping[str, Comparison], summary: StudySummary) -> Section:
    """Build a table of the average rank and the significant differences of each algorithm.

    There is one row per algorithm, best first. The columns are those of `StudySummary.ranks`.

    Parameters
    ----------
    comparisons : mapping of str to Comparison
        Finished comparisons by problem label.
    summary : StudySummary
        Result of `mgeo.studies.conclusions.summarize_study`.
    """
    name, ranks = summary.algorithm, summary.ranks
    table = pd.DataFrame(
        {
            "average rank": ranks["average_rank"].map("{:.2f}".format),
            "best on": ranks["best_on"].map("{:d}".format),
            **{key: ranks[key].map("{:.0f}".format) for key in ("better", "equal", "worse")},
            "p": ranks["p_holm"].map("{:.2g}".format),
        }
    )
    table.loc[name, ["better", "equal", "worse", "p"]] = "-"
    return Section(
        f"Ranks over {len(comparisons)} problems",
        table=table.rename_axis("algorithm"),
        note=f"Average rank: 1 for the {format_criterion(comparisons)} on a problem, averaged over "
        f"the problems.{_describe_zero_ranks(comparisons)}\n"
        "Best on: number of problems on which the algorithm ranks first, alone or tied.\n"
        "Better, equal, worse: number of problems on which the algorithm is significantly better "
        f"than, not significantly different from, and significantly worse than {name} "
        f"({format_test_method(summary.is_control)}).\n"
        f"p: signed-rank test of the algorithm against {name} over all problems, with Holm's "
        f"correction.{_describe_smallest_p(summary, len(comparisons))}",
    )


def _describe_zero_ranks(comparisons: Mapping[str, Comparison]) -> str:
    if not any(map(_has_zero_hypervolume, comparisons.values())):
        return ""
    return (
        " For the ranks and p, runs of zero hypervolume are compared by their additive epsilon; "
        f"the tests on a single problem treat them as equal. {_ZERO_HYPERVOLUME}"
    )


def _has_zero_hypervolume(comparison: Comparison) -> bool:
    final = comparison.select_final_rows()
    return "hypervolume" in final and bool((final["hypervolume"] == 0.0).any())


def _describe_smallest_p(summary: StudySummary, n_problems: int) -> str:
    """Return a warning if a study has too few problems to find significant differences."""
    n, k = summary.n_functions, len(summary.ranks)
    smallest = (k - 1) * 2.0 ** (1 - n)  # All differences of the exact test have equal signs.
    if smallest < SIGNIFICANCE_LEVEL:
        return ""
    kind = "problem" if n == n_problems else "function"
    blocks = f"{n} {kind}s are" if n > 1 else f"A single {kind} is"
    return f" {blocks} too few for this test to find a significant difference."


def build_budget_table(ranks: pd.DataFrame, study: Study) -> Section:
    """Build a table of the average rank of each algorithm at several evaluation budgets.

    The budgets are the full budget and the measured budgets nearest to 1/2, 1/4, 1/8 and 1/16 of
    it. If problems differ in their number of variables, each number has its own rows, in addition
    to those for all problems.

    Parameters
    ----------
    ranks : DataFrame
        Result of `mgeo.studies.aggregation.compute_average_ranks`.
    study : Study
        Study of the problems.
    """
    shown = ranks[ranks["evaluations"].isin(_select_budgets(ranks["evaluations"].to_numpy()))]
    stars = (shown["p_holm"] >= SIGNIFICANCE_LEVEL).map({True: "*", False: ""})
    texts = shown.assign(text=shown["average_rank"].map("{:.2f}".format) + stars)
    keys = ["variables", "problems", "evaluations"]
    table = texts.pivot(index=keys, columns="algorithm", values="text")
    order = shown[(shown["evaluations"] == shown["evaluations"].max()) & (shown["variables"] == 0)]
    table = table[order["algorithm"]].reset_index().rename_axis(columns=None)
    title = f"evaluations{' per variable' if study.per_variable else ''}"
    table["evaluations"] = table["evaluations"].map("{:,.10g}".format)
    table["variables"] = table["variables"].replace({0: "all"})
    if not ranks["variables"].any():
        table = table.drop(columns=["variables", "problems"])
    table = table.rename(columns={"evaluations": title})
    return Section(
        "Average ranks during the runs",
        table=table.set_index(table.columns[0]),
        note="Rank of the median of the default indicator over the runs on a problem, averaged "
        "over the problems; 1 is the best. Instances and sizes of one function are averaged first. "
        "Runs of zero hypervolume rank by their additive epsilon. An algorithm whose runs all "
        "failed on a problem ranks last on this problem.\n"
        "A star marks algorithms that do not differ significantly from "
        f"{study.control or 'the best of the row'} (signed-rank test over all problems at "
        f"{100 * SIGNIFICANCE_LEVEL:g} %, with Holm's correction).",
    )


def _select_budgets(evaluations: NDArray[np.float64]) -> NDArray[np.float64]:
    """Select at most `_MAX_BUDGETS` evaluation counts, spaced by about a factor of two."""
    counts = np.unique(evaluations)
    if len(counts) <= _MAX_BUDGETS:
        return counts
    targets = counts[-1] / 2.0 ** np.arange(_MAX_BUDGETS)
    distances = np.abs(np.log(counts[:, None] / targets))
    return np.unique(counts[distances.argmin(axis=0)])


def build_behind_table(summary: StudySummary) -> Section | None:
    """Build a table of the problems on which the reference algorithm is significantly worse.

    There is one row per problem and better algorithm. The reference is `summary.algorithm`.

    Parameters
    ----------
    summary : StudySummary
        Result of `mgeo.studies.conclusions.summarize_study`.

    Returns
    -------
    Section or None
        None if no algorithm is significantly better on any problem.
    """
    rows = summary.pairs[summary.pairs["result"] == "behind"]
    if not len(rows):
        return None
    table = pd.DataFrame(
        {
            "algorithm": rows["algorithm"].to_list(),
            "A": rows["A"].map("{:.2f}".format).to_list(),
            "p": rows["p_holm"].map("{:.2g}".format).to_list(),
        },
        index=pd.Index(rows["problem"], name="problem"),
    )
    return Section(
        f"Algorithms that are significantly better than {summary.algorithm}",
        table=table,
        note=f"A: probability that a run of {summary.algorithm} is better than a run of the "
        "algorithm.",
    )


def build_result_table(comparison: Comparison) -> Section:
    """Build a table of quality indicators on one problem, best algorithm first.

    The columns are the mean ± standard deviation of each indicator of a whole front and, if runs
    failed, the number of finished runs.
    """
    overview = comparison.format_overview()
    order = comparison.rank_algorithms()
    order += [name for name in overview.index if name not in order]
    titles = [indicator.title for indicator in comparison.indicators]
    if overview["runs"].nunique() > 1:
        titles.insert(0, "runs")
    note = (
        "Mean ± standard deviation of the runs.\n"
        f"Order of the rows: mean rank of the runs by {comparison.select_indicator().title}, among "
        "the runs of all algorithms. It can differ from the order of the means."
    )
    if _has_zero_hypervolume(comparison):
        note += f"\n{_ZERO_HYPERVOLUME}"
    return Section(
        f"Indicators after {comparison.n_eval:,} evaluations",
        table=overview.loc[order, titles].rename_axis("algorithm"),
        note=note,
    )


def build_published_table(study: Study, comparison: Comparison) -> Section | None:
    """Build a table of published and measured values, one row per quantity and algorithm.

    Returns
    -------
    Section or None
        None if the study has no published values, or if the published runs had another number of
        evaluations.
    """
    published = find_published_values(study, comparison)
    if published is None:
        return None
    overview = comparison.format_overview()
    titles = {indicator.name: indicator.title for indicator in comparison.indicators}
    rows = [
        (name, label, f"{value:.12g}", overview.loc[label, titles.get(name, name)])
        for label, values in published.table.items()
        for name, value in values.items()
        if titles.get(name, name) in overview
    ]
    table = pd.DataFrame(rows, columns=["quantity", "algorithm", "published", "measured"])
    order = table["quantity"].unique()
    return Section(
        f"Comparison with {published.source}",
        table=table.set_index("quantity").loc[order],
        note="Measured: mean ± standard deviation of the runs.",
    )
