"""Tables of the studies, which several pages share."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import pandas as pd
from IPython.display import Markdown
from stored_studies import (
    CONTROL,
    HERE,
    load,
    load_ranks,
    load_values,
    locate_results,
    read_provenance,
)

from mgeo.studies import Comparison, read_study
from mgeo.studies.aggregation import (
    KEY_COLUMNS,
    compute_average_ranks,
    compute_friedman_test,
    compute_problem_values,
)
from mgeo.studies.comparison_files import PROVENANCE_FILE
from mgeo.studies.conclusions import compare_with_rivals, format_control_table
from mgeo.studies.indicators import build_indicator_space, build_part_indicators
from mgeo.studies.statistics import SIGNIFICANCE_LEVEL
from mgeo.studies.tables import format_markdown

_ORDINALS = ("first", "second", "third", "fourth", "fifth", "sixth", "seventh")


def rank_problems(comparisons: Mapping[str, Comparison]) -> pd.DataFrame:
    """Return the average ranks over problems at the end of the runs, with tests."""
    values = compute_problem_values(comparisons)
    ranks = compute_average_ranks(
        values[values["evaluations"] == values["evaluations"].max()], CONTROL
    )
    return ranks[ranks["variables"] == 0]


def size(name: str) -> Markdown:
    """Return a text with the numbers of evaluations, seeds and runs of a study, and versions."""
    study = read_study(HERE / f"{name}.toml", allow_imports=False)
    provenance = [
        read_provenance(place / PROVENANCE_FILE) for place in locate_results(name, study).values()
    ]
    first = provenance[0]
    evaluations, seeds = first["evaluations"], len(first["seeds"])
    if study.per_variable:
        evaluations //= load(name)[1][first["problem"]["label"]].problem.n_var
    versions = ", ".join(
        f"{package} {v if isinstance(v, str) else ' and '.join(v)}"
        for package, v in first["versions"].items()
    )
    each = " per variable" if study.per_variable else ""
    failed = sum(data["runs_failed"] for data in provenance)
    text = (
        f"Results on this page: **{evaluations:,} evaluations{each}, {seeds} seeds**, "
        f"{sum(data['runs_finished'] for data in provenance):,} runs"
        + (f" and {failed} failed runs" if failed else "")
        + f"; {max(data['written'] for data in provenance)[:10]}, with {versions}, "
        "the versions at that time."
    )
    if (evaluations, seeds) != (study.evaluations, len(study.seeds)):
        text += (
            "\n\n```{warning}\nThese results test the page only. The study has "
            f"{study.evaluations:,} evaluations{each} and {len(study.seeds)} seeds. Do not draw "
            "conclusions from these numbers.\n```"
        )
    return Markdown(text)


def ranks_and_shares(
    ranks: pd.DataFrame, budgets: Sequence[int]
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return two tables: average ranks, and shares of problems on which the control is better.

    Rows are algorithms. Columns are titled *variables: budget*. A star marks ranks without a
    significant difference from the control.
    """
    shown = ranks[ranks["evaluations"].isin(budgets)]
    stars = (shown["p_holm"] >= SIGNIFICANCE_LEVEL).map({True: "*", False: ""})
    shown = shown.assign(
        text=shown["average_rank"].map("{:.2f}".format) + stars,
        after=shown["variables"].map(lambda n: f"{n or 'all'}: ")
        + shown["evaluations"].map("{:,.0f}".format),
        share=shown["share_control_better"]
        .map("{:.0%}".format)
        .where(shown["share_control_better"].notna(), ""),
    )
    order = shown.groupby("algorithm")["average_rank"].mean().sort_values(kind="stable").index
    averages, shares = (
        shown.pivot(index="algorithm", columns="after", values=column).loc[
            order, shown["after"].unique()
        ]
        for column in ("text", "share")
    )
    return averages.rename_axis(index="average rank", columns=None), shares


def after(name: str, evaluations: int, variables: int = 0) -> pd.DataFrame:
    """Return the average ranks of a study after a budget, over all problems or one size only."""
    ranks = load_ranks(name)
    return ranks[(ranks["evaluations"] == evaluations) & (ranks["variables"] == variables)]


def ranked(columns: Mapping[str, pd.DataFrame]) -> Markdown:
    """Return a table of average ranks over functions, 1 being the best.

    A star marks a rival that is not significantly different from the control. A rival that is
    better than the control is bold.

    Parameters
    ----------
    columns : mapping of str to DataFrame
        Rows of `compute_average_ranks` for one size and budget, by column title.
    """
    texts = {}
    for title, rows in columns.items():
        rivals = rows.set_index("algorithm").rename(columns={"share_control_better": "A"})
        ranks = rivals["average_rank"].map("{:.2f}".format)
        texts[title] = _marked(ranks, rivals)
    return table(pd.DataFrame(texts).rename_axis("average rank"))


def functions_ahead(name: str, rivals: Sequence[str], budgets: Sequence[int]) -> Markdown:
    """Return a table of the functions on which the control is better and worse than each rival.

    The control is better on a function if it is better on most of the problems of this function.
    The table has the number of these functions after each budget, and the names of the functions
    on which the control is worse, the worst first.
    """
    values = load_values(name)
    rows = {}
    for rival in rivals:
        for evaluations in budgets:
            now = values[values["evaluations"] == evaluations]
            ahead = (now[CONTROL] > now[rival]) + 0.5 * (now[CONTROL] == now[rival])
            shares = ahead.groupby(now["function"].str.split().str[-1]).mean().sort_values()
            behind = ", ".join(shares.index[shares < 0.5])
            rows[f"{rival}: {evaluations:,}"] = {
                "ahead": f"{(shares > 0.5).sum()} of {len(shares)}",
                "behind": behind or "none",
            }
    return table(pd.DataFrame(rows).T.rename_axis("rival: evaluations per variable"))


def mean_values(name: str, budgets: Sequence[int]) -> Markdown:
    """Return a table of the mean hypervolume over the problems of a study after each budget."""
    values = load_values(name)
    names = values.columns.drop(list(KEY_COLUMNS))
    means = values[names].clip(lower=0.0).groupby(values["evaluations"]).mean().loc[list(budgets)]
    texts = means.map("{:.3f}".format).set_axis([f"{each:,}" for each in budgets])
    return table(texts.T.rename_axis("algorithm"))


def table(values: pd.DataFrame) -> Markdown:
    """Return a table in Markdown, without line breaks between mean and standard deviation."""
    return Markdown(format_markdown(values).replace(" ± ", "\N{NO-BREAK SPACE}±\N{NO-BREAK SPACE}"))


def control_against(comparison: Comparison) -> Markdown:
    """Return a table that compares the control with all other algorithms by all indicators."""
    return table(format_control_table(comparison, CONTROL, comparison.indicators))


def at_budgets(comparison: Comparison, budgets: Sequence[int]) -> Markdown:
    """Return a table of the mean indicators after several budgets.

    A star marks a rival that is not significantly different from the control.
    """
    columns = {}
    for name in ("hypervolume", "igd_plus"):
        for evaluations in budgets:
            then = replace(comparison, n_eval=evaluations)
            title = f"{then.select_indicator(name).title}, {evaluations:,}"
            columns[title] = _mean_with_stars(then, name)
    return table(pd.DataFrame(columns).loc[comparison.rank_algorithms()].rename_axis("algorithm"))


def _mean_with_stars(comparison: Comparison, indicator: str) -> "pd.Series[str]":
    """Return the means of an indicator, with a star at insignificantly different rivals."""
    values = comparison.summarize()[(indicator, "mean")].map("{:.4f}".format)
    rivals = compare_with_rivals(comparison, CONTROL, indicator, is_control=True)
    p = rivals["p_holm"].reindex(values.index)
    return values + p.map(lambda p: "*" if p >= SIGNIFICANCE_LEVEL else "")


def by_parts(comparison: Comparison, parts: Sequence[float] = ()) -> Markdown:
    """Return a table of the mean hypervolume by parts of the front.

    A star marks a rival that is not significantly different from the control. A rival that is
    better than the control is bold.

    Parameters
    ----------
    parts : sequence of float
        Limits of the parts in the first objective, if the study does not define them. The
        hypervolume is then computed from the stored fronts.
    """
    if parts:
        fronts = {key: run.front_F for key, run in comparison.finished_runs.items()}
        space = build_indicator_space(comparison.problem, fronts.values(), parts=parts)
        final = comparison.select_final_rows()
        for part in build_part_indicators(space, ""):
            measured = {key: part.evaluate(space(F), space) for key, F in fronts.items()}
            final[part.name] = [measured[row.algorithm, row.seed] for row in final.itertuples()]
        comparison = replace(comparison, table=final, space=space)
    columns = {}
    for part in comparison.part_indicators:
        values = comparison.summarize()[(part.name, "mean")].map("{:.4f}".format)
        rivals = compare_with_rivals(comparison, CONTROL, part.name, is_control=True)
        columns[part.title] = _marked(values, rivals)
    return table(pd.DataFrame(columns).loc[comparison.rank_algorithms()].rename_axis("algorithm"))


def on_each(name: str) -> Markdown:
    """Return a table of the mean hypervolume on each problem, or of IGD+ with many objectives.

    A star marks a rival that is not significantly different from the control. A rival that is
    better than the control is bold.
    """
    _, found = load(name)
    columns = {}
    for label, comparison in found.items():
        first = comparison.select_indicator()
        values = comparison.summarize()[(first.name, "mean")]
        rivals = compare_with_rivals(comparison, CONTROL, first.name, is_control=True)
        title = label if first.is_maximized else f"{label}, {first.title}"
        columns[title] = _marked(values.map("{:.3f}".format), rivals)
    return table(pd.DataFrame(columns).rename_axis("algorithm"))


def _marked(values: "pd.Series[str]", rivals: pd.DataFrame) -> "pd.Series[str]":
    """Mark texts of insignificantly different rivals by a star, and make better rivals bold."""
    rivals = rivals.reindex(values.index)
    is_equivalent = rivals["p_holm"] >= SIGNIFICANCE_LEVEL
    values = values.where(~is_equivalent, values + "*")
    return values.where(is_equivalent | ~(rivals["A"] < 0.5), "**" + values + "**")


def with_and_without(name: str) -> Markdown:
    """Return a table of the average ranks over the original problems and over the shifted ones."""
    _, found = load(name)
    parts: dict[str, dict[str, Comparison]] = {"as they are": {}, "shifted": {}}
    for label, comparison in found.items():
        parts["shifted" if label.startswith("shifted") else "as they are"][label] = comparison
    ranks = {}
    for title, part in parts.items():
        test = compute_friedman_test(compute_problem_values(part))
        ranks[title] = pd.Series({**test.ranks, "critical difference": test.critical_difference})
    texts = pd.DataFrame(ranks).map("{:.2f}".format)
    return table(texts.loc[ranks["shifted"].index].rename_axis("average rank"))


def on_each_against(name: str, rival: str) -> Markdown:
    """Return a table of the mean hypervolume on each problem, and the comparison with a rival."""
    _, found = load(name)
    rows = {}
    for label, comparison in found.items():
        rows[label] = comparison.summarize()[("hypervolume", "mean")].map("{:.3f}".format)
        for indicator in ("hypervolume", "igd_plus", "epsilon"):
            p = compare_with_rivals(comparison, CONTROL, indicator, is_control=True).loc[rival]
            title = f"A, p by {comparison.select_indicator(indicator).title}"
            rows[label][title] = f"{p['A']:.2f}, {p['p_holm']:.2g}"
    return table(pd.DataFrame(rows).T.rename_axis("problem"))


def means(found: Mapping[str, Comparison], suite: str) -> pd.DataFrame:
    """Return the mean hypervolume of each algorithm on each problem of a suite, best in bold."""
    columns = {}
    for label, comparison in found.items():
        if label.startswith(suite):
            values = comparison.summarize()[("hypervolume", "mean")]
            texts = values.map("{:.3f}".format)
            columns[label] = texts.where(values < values.max(), "**" + texts + "**")
    return pd.DataFrame(columns).rename_axis("algorithm")


def count_ahead(ranks: pd.DataFrame, rival: str) -> str:
    """Return the number of functions on which the control is ahead of a rival, as "16 of 21"."""
    row = ranks[ranks["algorithm"] == rival].iloc[0]
    return f"{row['n_functions_control_better']:g} of {row['functions']}"


def wins(columns: Mapping[str, pd.DataFrame]) -> Markdown:
    """Return a table with the numbers of functions on which the control is ahead of each rival.

    A star marks a rival that is not significantly different from the control.

    Parameters
    ----------
    columns : mapping of str to DataFrame
        Rows of `compute_average_ranks` for one size and budget, by column title.
    """
    texts = {}
    for title, ranks in columns.items():
        rivals = ranks[ranks["p_holm"].notna()].set_index("algorithm")
        stars = rivals["p_holm"].map(lambda p: "*" if p >= SIGNIFICANCE_LEVEL else "")
        texts[title] = pd.Series({name: count_ahead(ranks, name) for name in rivals.index}) + stars
    counts = pd.concat(texts, axis=1).fillna("")
    return table(counts.rename_axis(f"{CONTROL} ahead of"))


def find_place(ranks: pd.DataFrame, name: str = CONTROL) -> str:
    """Return the place of an algorithm by average rank, as "first of six"."""
    place = list(ranks.sort_values("average_rank")["algorithm"]).index(name)
    return f"{_ORDINALS[place]} of {len(ranks)}"


def find_best_rival(comparison: Comparison) -> tuple[str, float]:
    """Return the rival with the largest mean hypervolume at the end of the runs, and the mean."""
    means = comparison.summarize()[("hypervolume", "mean")].drop(CONTROL)
    return str(means.idxmax()), float(means.max())


def count_evaluations_to_reach(comparison: Comparison, value: float) -> int:
    """Return the first measured number of evaluations at which the control reaches a mean."""
    rows = comparison.table[comparison.table["algorithm"] == CONTROL]
    means = rows.groupby("evaluations")["hypervolume"].mean()
    return int(means.index[means >= value].min())


def at_budgets_of_all(comparisons: Mapping[str, Comparison], budgets: Sequence[int]) -> Markdown:
    """Return a table of the mean hypervolume on several problems after several budgets.

    A star marks a rival that is not significantly different from the control.
    """
    columns = {
        f"{label}: {evaluations:,}": _mean_with_stars(
            replace(comparison, n_eval=evaluations), "hypervolume"
        )
        for label, comparison in comparisons.items()
        for evaluations in budgets
    }
    return table(pd.DataFrame(columns).rename_axis("algorithm"))


def mean_and_deviation(runs: pd.DataFrame) -> Markdown:
    """Return a table of mean and standard deviation of the hypervolume by budget."""
    groups = runs.groupby(["algorithm", "evaluations"])["hypervolume"].agg(["mean", "std"])
    texts = groups["mean"].map("{:.3f} ± ".format) + groups["std"].map("{:.3f}".format)
    texts = texts.unstack().rename(columns="{:,} evaluations".format)
    order = groups["mean"].groupby("algorithm").max().sort_values(ascending=False).index
    return table(texts.loc[order].rename_axis("algorithm"))
