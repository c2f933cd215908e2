"""Tables of the results of a study, which the terminal and the report pages share."""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd

from mgeo.plugins.review import Section
from mgeo.studies.comparison import Comparison
from mgeo.studies.conclusions import (
    StudySummary,
    find_published_values,
    format_criterion,
    format_test_method,
)
from mgeo.studies.study_file import Study


def build_rank_table(comparisons: Mapping[str, Comparison], summary: StudySummary) -> Section:
    """Build a table of average ranks and significant differences over all problems of a study.

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
            **{key: ranks[key].map("{:.0f}".format) for key in ("ahead", "even", "behind")},
            "p": ranks["p_holm"].map("{:.2g}".format),
        }
    )
    table.loc[name, ["ahead", "even", "behind", "p"]] = "-"
    return Section(
        f"Ranks over {len(comparisons)} problems",
        table=table.rename_axis("algorithm"),
        note=f"Best on: number of problems with the {format_criterion(comparisons)}; ties count "
        "for each algorithm.\nAhead, even, behind: number of problems on which "
        f"{name} is significantly better than, not significantly different from, and "
        "significantly worse than the algorithm "
        f"({format_test_method(summary.is_control)}).\np: signed-rank test of {name} against the "
        "algorithm over all problems, with Holm's correction.",
    )


def build_behind_table(summary: StudySummary) -> Section | None:
    """Build a table of the algorithms that are significantly better on a problem.

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
    """Build a table of the indicators of each algorithm on one problem, best algorithm first.

    The columns are the mean ± standard deviation of each indicator of a whole front and, if runs
    failed, the number of finished runs.
    """
    overview = comparison.format_overview()
    order = comparison.rank_algorithms()
    order += [name for name in overview.index if name not in order]
    titles = [indicator.title for indicator in comparison.indicators]
    if overview["runs"].nunique() > 1:
        titles.insert(0, "runs")
    return Section(
        f"Indicators after {comparison.n_eval:,} evaluations",
        table=overview.loc[order, titles].rename_axis("algorithm"),
        note="Mean ± standard deviation of the runs.",
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
