"""Functions that the pages of the studies share: they load stored results and format tables."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import pandas as pd
from IPython.display import Markdown

from mgeo.studies import Comparison, Study, read_comparison, read_study
from mgeo.studies.aggregation import (
    compute_average_ranks,
    compute_friedman_test,
    compute_problem_values,
)
from mgeo.studies.comparison_files import PROVENANCE_FILE, format_folder_name
from mgeo.studies.conclusions import compare_with_rivals, format_control_table
from mgeo.studies.indicators import build_indicator_space, build_part_indicators
from mgeo.studies.report import format_average_ranks
from mgeo.studies.statistics import SIGNIFICANCE_LEVEL
from mgeo.studies.tables import format_markdown

HERE = Path(__file__).parent


def load(name: str) -> tuple[Study, dict[str, Comparison]]:
    """Return a study and its stored comparisons by problem label."""
    study = read_study(HERE / f"{name}.toml", allow_imports=False)
    return study, {label: read_comparison(place) for label, place in _places(name, study).items()}


def size(name: str) -> Markdown:
    """Return a text with the numbers of evaluations, seeds and runs of a study, and versions."""
    study = read_study(HERE / f"{name}.toml", allow_imports=False)
    provenance = [
        json.loads((place / PROVENANCE_FILE).read_text(encoding="utf-8"))
        for place in _places(name, study).values()
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
        + f"; {max(data['written'] for data in provenance)[:10]}, with {versions}."
    )
    if (evaluations, seeds) != (study.evaluations, len(study.seeds)):
        text += (
            "\n\n```{warning}\nThese results test the page only. The study has "
            f"{study.evaluations:,} evaluations{each} and {len(study.seeds)} seeds. Do not draw "
            "conclusions from these numbers.\n```"
        )
    return Markdown(text)


def pooled(name: str) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return the stored tables of ranks and targets of a study of many problems."""
    place = HERE / "data" / name
    return pd.read_csv(place / "ranks.csv"), pd.read_csv(place / "targets.csv")


def ranks_and_shares(
    ranks: pd.DataFrame, budgets: Sequence[int]
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return two tables: average ranks, and shares of problems on which the control is better.

    Rows are algorithms. Columns are titled *variables: budget*.
    """
    shown = ranks[ranks["evaluations"].isin(budgets)]
    shown = shown.assign(
        after=shown["variables"].map(lambda n: f"{n or 'all'}: ")
        + shown["evaluations"].map("{:,.0f}".format),
        share=shown["share_control_better"]
        .map("{:.0%}".format)
        .where(shown["share_control_better"].notna(), ""),
    )
    averages = format_average_ranks(shown, per_variable=True).T
    averages = averages.set_axis(shown["after"].unique(), axis=1).rename_axis("average rank")
    shares = shown.pivot(index="algorithm", columns="after", values="share")
    return averages, shares.loc[averages.index]


def after(name: str, evaluations: int, variables: int = 0) -> pd.DataFrame:
    """Return the average ranks of a study after a budget, over all problems or one size only."""
    ranks = pooled(name)[0]
    return ranks[(ranks["evaluations"] == evaluations) & (ranks["variables"] == variables)]


def under_noise() -> dict[float, pd.DataFrame]:
    """Return the average ranks over functions for each noise level of docs/studies/noise.py."""
    rows = pd.read_csv(HERE / "data" / "noise.csv")
    ranks = {}
    for noise, now in rows.groupby("noise"):
        values = now.pivot_table("hypervolume", "problem", "algorithm").reset_index()
        # All problems have the same size and budget, and each function occurs once.
        values = values.assign(function=values["problem"], variables=0, evaluations=0)
        ranks[noise] = compute_average_ranks(values, "MGEO directed (ours)")
    return ranks


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
    values = pd.read_csv(HERE / "data" / name / "values.csv")
    control = read_study(HERE / f"{name}.toml", allow_imports=False).control
    rows = {}
    for rival in rivals:
        for evaluations in budgets:
            now = values[values["evaluations"] == evaluations]
            ahead = (now[control] > now[rival]) + 0.5 * (now[control] == now[rival])
            shares = ahead.groupby(now["function"].str.split().str[-1]).mean().sort_values()
            behind = ", ".join(shares.index[shares < 0.5])
            rows[f"{rival}: {evaluations:,}"] = {
                "ahead": f"{(shares > 0.5).sum()} of {len(shares)}",
                "behind": behind or "none",
            }
    return table(pd.DataFrame(rows).T.rename_axis("rival: evaluations per variable"))


def mean_values(name: str, budgets: Sequence[int]) -> Markdown:
    """Return a table of the mean hypervolume over the problems of a study after each budget."""
    values = pd.read_csv(HERE / "data" / name / "values.csv")
    names = [
        algorithm.label
        for algorithm in read_study(HERE / f"{name}.toml", allow_imports=False).algorithms
    ]
    means = values[names].clip(lower=0.0).groupby(values["evaluations"]).mean().loc[list(budgets)]
    texts = means.map("{:.3f}".format).set_axis([f"{each:,}" for each in budgets])
    return table(texts.T.rename_axis("algorithm"))


def polished() -> Markdown:
    """Return a table of gain and cost of the local refinement, by docs/studies/polished.py."""
    rows = pd.read_csv(HERE / "data" / "polished.csv").fillna(0)
    rows["front"] = rows["algorithm"] + rows["stage"].map({"search": "", "polish": ", refined"})
    columns = {
        "hypervolume_1": ("hypervolume, to 1200", "{:.4f}"),
        "hypervolume_2": ("from 1200 to 6000", "{:.4f}"),
        "hypervolume_3": ("from 6000", "{:.4f}"),
        "whole": ("plans evaluated", "{:,.0f}"),
        "at_one_time": ("at one time", "{:,.0f}"),
        "cpu_s": ("CPU [s]", "{:.1f}"),
    }
    means = rows.groupby("front", sort=False)[list(columns)].mean()
    return table(pd.DataFrame({title: means[c].map(f.format) for c, (title, f) in columns.items()}))


def table(values: pd.DataFrame) -> Markdown:
    """Return a table in Markdown, without line breaks between mean and standard deviation."""
    return Markdown(format_markdown(values).replace(" ± ", "\N{NO-BREAK SPACE}±\N{NO-BREAK SPACE}"))


def control_against(study: Study, comparison: Comparison) -> Markdown:
    """Return a table that compares the control with all other algorithms by all indicators."""
    assert study.control is not None
    return table(format_control_table(comparison, study.control, comparison.indicators))


def at_budgets(study: Study, comparison: Comparison, budgets: Sequence[int]) -> Markdown:
    """Return a table of the mean indicators after several budgets.

    A star marks a rival that is not significantly different from the control.
    """
    assert study.control is not None
    columns = {}
    for name in ("hypervolume", "igd_plus"):
        for evaluations in budgets:
            then = replace(comparison, n_eval=evaluations)
            values = then.summarize()[(name, "mean")].map("{:.4f}".format)
            p = compare_with_rivals(then, study.control, name, is_control=True)["p_holm"].reindex(
                values.index
            )
            columns[f"{then.select_indicator(name).title}, {evaluations:,}"] = values + p.map(
                lambda p: "*" if p >= SIGNIFICANCE_LEVEL else ""
            )
    return table(pd.DataFrame(columns).loc[comparison.rank_algorithms()].rename_axis("algorithm"))


def by_parts(study: Study, comparison: Comparison, parts: Sequence[float] = ()) -> Markdown:
    """Return a table of the mean hypervolume by parts of the front.

    A star marks a rival that is not significantly different from the control. A rival that is
    better than the control is bold.

    Parameters
    ----------
    parts : sequence of float
        Limits of the parts in the first objective, if the study does not define them. The
        hypervolume is then computed from the stored fronts.
    """
    assert study.control is not None
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
        rivals = compare_with_rivals(comparison, study.control, part.name, is_control=True)
        columns[part.title] = _marked(values, rivals)
    return table(pd.DataFrame(columns).loc[comparison.rank_algorithms()].rename_axis("algorithm"))


def on_each(name: str) -> Markdown:
    """Return a table of the mean hypervolume on each problem, or of IGD+ with many objectives.

    A star marks a rival that is not significantly different from the control. A rival that is
    better than the control is bold.
    """
    study, found = load(name)
    assert study.control is not None
    columns = {}
    for label, comparison in found.items():
        first = comparison.select_indicator()
        values = comparison.summarize()[(first.name, "mean")]
        rivals = compare_with_rivals(comparison, study.control, first.name, is_control=True)
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
    study, found = load(name)
    assert study.control is not None
    rows = {}
    for label, comparison in found.items():
        rows[label] = comparison.summarize()[("hypervolume", "mean")].map("{:.3f}".format)
        for indicator in ("hypervolume", "igd_plus", "epsilon"):
            p = compare_with_rivals(comparison, study.control, indicator, is_control=True).loc[
                rival
            ]
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


def _places(name: str, study: Study) -> dict[str, Path]:
    """Return the folder with the results of each problem, by label."""
    data = HERE / "data" / name
    if len(study.problems) == 1:
        return {study.problems[0].label: data}
    return {case.label: data / format_folder_name(case.label) for case in study.problems}
