"""What the pages of the studies share: the results kept beside them, and a word on their size."""

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
    """A study and what is kept of it, by problem."""
    study = read_study(HERE / f"{name}.toml", allow_imports=False)
    return study, {label: read_comparison(place) for label, place in _places(name, study).items()}


def size(name: str) -> Markdown:
    """How much of a study is kept, and by what it was made."""
    study = read_study(HERE / f"{name}.toml", allow_imports=False)
    made = [
        json.loads((place / PROVENANCE_FILE).read_text(encoding="utf-8"))
        for place in _places(name, study).values()
    ]
    first = made[0]
    evaluations, seeds = first["evaluations"], len(first["seeds"])
    if study.per_variable:
        evaluations //= load(name)[1][first["problem"]["label"]].problem.n_var
    versions = ", ".join(
        f"{package} {v if isinstance(v, str) else ' and '.join(v)}"
        for package, v in first["versions"].items()
    )
    each = " per variable" if study.per_variable else ""
    failed = sum(data["runs_failed"] for data in made)
    text = (
        f"Shown here: **{evaluations:,} evaluations{each}, {seeds} seeds**, "
        f"{sum(data['runs_finished'] for data in made):,} runs"
        + (f" and {failed} that failed" if failed else "")
        + f"; {max(data['written'] for data in made)[:10]}, with {versions}."
    )
    if (evaluations, seeds) != (study.evaluations, len(study.seeds)):
        text += (
            "\n\n```{warning}\nThat is a trial of the page, not the study, which has "
            f"{study.evaluations:,} evaluations{each} and {len(study.seeds)} seeds. Nothing "
            "follows from these numbers.\n```"
        )
    return Markdown(text)


def pooled(name: str) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Ranks and targets of a study of many problems, of which only these are kept."""
    place = HERE / "data" / name
    return pd.read_csv(place / "ranks.csv"), pd.read_csv(place / "targets.csv")


def ranks_and_shares(
    ranks: pd.DataFrame, budgets: Sequence[int]
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Average ranks, and shares of problems on which the control is ahead; *variables: budget*."""
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
    """Rows of a study's pooled ranks: of all problems, or of those of one size."""
    ranks = pooled(name)[0]
    return ranks[(ranks["evaluations"] == evaluations) & (ranks["variables"] == variables)]


def under_noise() -> dict[float, pd.DataFrame]:
    """Ranks over functions by the noise on their values: docs/studies/noise.py."""
    rows = pd.read_csv(HERE / "data" / "noise.csv")
    ranks = {}
    for noise, now in rows.groupby("noise"):
        values = now.pivot_table("hypervolume", "problem", "algorithm").reset_index()
        # of one size and budget, and no function twice
        values = values.assign(function=values["problem"], variables=0, evaluations=0)
        ranks[noise] = compute_average_ranks(values, "MGEO directed (ours)")
    return ranks


def ranked(columns: Mapping[str, pd.DataFrame]) -> Markdown:
    """Average ranks over functions, 1 being the best; a star where a rival is not significantly
    different from the control, in bold where it is ahead of it.

    Parameters
    ----------
    columns : by title, rows of `compute_average_ranks` of one size and budget.
    """
    texts = {}
    for title, rows in columns.items():
        rivals = rows.set_index("algorithm").rename(columns={"share_control_better": "A"})
        ranks = rivals["average_rank"].map("{:.2f}".format)
        texts[title] = _marked(ranks, rivals)
    return table(pd.DataFrame(texts).rename_axis("average rank"))


def functions_ahead(name: str, rivals: Sequence[str], budgets: Sequence[int]) -> Markdown:
    """Against each rival after each budget: on how many functions the control is ahead on most of
    their problems, and on which it is behind on most, the worst first."""
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
    """Mean hypervolume over the problems of a study after each budget, 0 where there is none."""
    values = pd.read_csv(HERE / "data" / name / "values.csv")
    names = [
        algorithm.label
        for algorithm in read_study(HERE / f"{name}.toml", allow_imports=False).algorithms
    ]
    means = values[names].clip(lower=0.0).groupby(values["evaluations"]).mean().loc[list(budgets)]
    texts = means.map("{:.3f}".format).set_axis([f"{each:,}" for each in budgets])
    return table(texts.T.rename_axis("algorithm"))


def polished() -> Markdown:
    """What a polish adds to each part of the front, and what it takes: docs/studies/polished.py."""
    rows = pd.read_csv(HERE / "data" / "polished.csv").fillna(0)
    rows["front"] = rows["algorithm"] + rows["stage"].map({"search": "", "polish": ", polished"})
    columns = {
        "hypervolume_1": ("hypervolume, to 1200", "{:.4f}"),
        "hypervolume_2": ("from 1200 to 6000", "{:.4f}"),
        "hypervolume_3": ("from 6000", "{:.4f}"),
        "whole": ("plans judged", "{:,.0f}"),
        "at_one_time": ("at one time", "{:,.0f}"),
        "cpu_s": ("CPU [s]", "{:.1f}"),
    }
    means = rows.groupby("front", sort=False)[list(columns)].mean()
    return table(pd.DataFrame({title: means[c].map(f.format) for c, (title, f) in columns.items()}))


def table(values: pd.DataFrame) -> Markdown:
    """A table as the page's own, with no break within mean ± standard deviation."""
    return Markdown(format_markdown(values).replace(" ± ", "\N{NO-BREAK SPACE}±\N{NO-BREAK SPACE}"))


def control_against(study: Study, comparison: Comparison) -> Markdown:
    """The study's control against every other algorithm, by every indicator."""
    assert study.control is not None
    return table(format_control_table(comparison, study.control, comparison.indicators))


def at_budgets(study: Study, comparison: Comparison, budgets: Sequence[int]) -> Markdown:
    """Means after smaller budgets, too; a star where a rival is not significantly different."""
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
    """Mean hypervolume by parts of the front; a star where a rival is not significantly different
    from the control, in bold where it is ahead of it.

    Parameters
    ----------
    parts : of the first objective, where that was not measured; then of the fronts that are kept.
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
    """Mean hypervolume on each problem of a study, IGD+ where there is none.

    A star where a rival is not significantly different from the control, in bold where it is ahead.
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
    """Texts with a star where a rival is like the control, in bold where it is ahead of it."""
    rivals = rivals.reindex(values.index)
    alike = rivals["p_holm"] >= SIGNIFICANCE_LEVEL
    values = values.where(~alike, values + "*")
    return values.where(alike | ~(rivals["A"] < 0.5), "**" + values + "**")


def with_and_without(name: str) -> Markdown:
    """Average ranks over a study's problems as they are and over those that are shifted."""
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
    """Mean hypervolume on each problem, and the control against a rival by every indicator."""
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
    """Mean hypervolume, algorithms by problems of a suite, the highest of each in bold."""
    columns = {}
    for label, comparison in found.items():
        if label.startswith(suite):
            values = comparison.summarize()[("hypervolume", "mean")]
            texts = values.map("{:.3f}".format)
            columns[label] = texts.where(values < values.max(), "**" + texts + "**")
    return pd.DataFrame(columns).rename_axis("algorithm")


def _places(name: str, study: Study) -> dict[str, Path]:
    """Folder of each problem's results."""
    data = HERE / "data" / name
    if len(study.problems) == 1:
        return {study.problems[0].label: data}
    return {case.label: data / format_folder_name(case.label) for case in study.problems}
