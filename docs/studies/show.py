"""Functions that the pages of the studies share: they load stored results and format tables."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pandas as pd
from IPython.display import Markdown

from mgeo.runs.registry import ALGORITHMS
from mgeo.studies import Comparison, Study, read_comparison, read_study
from mgeo.studies.aggregation import (
    KEY_COLUMNS,
    compute_average_ranks,
    compute_friedman_test,
    compute_problem_values,
)
from mgeo.studies.comparison_files import PROVENANCE_FILE, format_folder_name
from mgeo.studies.conclusions import compare_with_rivals, format_control_table
from mgeo.studies.indicators import build_indicator_space, build_part_indicators
from mgeo.studies.statistics import SIGNIFICANCE_LEVEL
from mgeo.studies.tables import format_markdown

HERE = Path(__file__).parent

#: Algorithm with which the studies compare all others.
CONTROL = "MGEODirected"
#: Names of algorithms on the pages, by their label in study files and stored results.
_NAMES = {name: record.label for name, record in ALGORITHMS.items()} | {
    "MGEO directed (ours)": CONTROL,
    "directed clip": CONTROL,
    "mgeo-directed": CONTROL,
    "directed reflect": f"{CONTROL}, reflect",
    "directed resample": f"{CONTROL}, resample",
    "ours without momentum": f"{CONTROL}, no momentum",
    "no covariance": f"{CONTROL}, no covariance",
    "MGEO_real clip": "MGEO_real, clip",
    "MGEO_real reflect": "MGEO_real, reflect",
    "MGEO_real σ 1": "MGEO_real, as published",
    "mo-cma-es": "MO-CMA-ES",
    "como-cma-es": "COMO-CMA-ES",
}
#: Label of `MGEODirected` with former constants, which the pages omit.
_FORMER = "ours, any targets"
#: Names of problems on the pages, by their label in study files.
_PROBLEMS = {
    "attitude paper": "paper's satellite",
    "attitude cubesat_6u": "6U CubeSat",
    "attitude paper over flights": "paper's satellite",
    "attitude cubesat_6u over flights": "6U CubeSat",
    "dtlz1 of two objectives": "dtlz1, 2 objectives",
    "dtlz3 of two objectives": "dtlz3, 2 objectives",
}
#: Changes of the ablation, by label in the study file.
_CHANGES = {
    "no selection pressure": "no selection pressure, τ = 0",
    "always the best": "the best candidate is always accepted, τ = 50",
    "no extreme weights": "no walkers with extreme weights",
    "no differences": "no difference steps",
    "one share of differences": "equal share of difference steps for all walkers, 0.4",
    "no coupling": "normal steps and differences in one variable only",
    "one coupling": "equal coupling of normal steps and differences, 0.2",
    "one width of steps": "one standard deviation of normal steps, 0.05",
    "no return": "no return to the best point",
    "no migration": "no return to the archive",
    "one migration": "equal return to the archive for all walkers, 0.1",
    "one restart": "equal patience for all walkers, 15 generations",
    "all variables tried": "up to 20 candidates per walker",
    "one variable tried": "one candidate per walker",
    "no attraction": "no differences towards the archive",
    "no momentum": "no steps with momentum",
    "nearest targets": "momentum to the nearest archived point only",
    "any targets": "momentum to random archived points only",
    "any progress counts": "any decrease of the distance is progress",
    "one measure of progress": "constant threshold of progress, 0.001",
    "one share of recombination": "constant share of recombination",
}
_ORDINALS = ("first", "second", "third", "fourth", "fifth", "sixth", "seventh")
#: Time at which recombination was added to `MGEODirected`.
_RECOMBINATION = "2026-11-29T03:56"


def format_name(label: str) -> str:
    """Return the name of an algorithm on the pages, from its label in a study."""
    return _NAMES.get(label, label.replace("MGEO_real σ ", "MGEO_real, σ = "))


def load(name: str) -> tuple[Study, dict[str, Comparison]]:
    """Return a study and its stored comparisons by problem label, with algorithms by name."""
    study = read_study(HERE / f"{name}.toml", allow_imports=False)
    comparisons = {
        _PROBLEMS.get(label, label): _rename(read_comparison(place))
        for label, place in _places(name, study).items()
    }
    return study, comparisons


def _rename(comparison: Comparison) -> Comparison:
    """Replace the labels of the algorithms by their names."""
    return replace(
        comparison,
        algorithms=tuple(map(format_name, comparison.algorithms)),
        table=comparison.table.assign(algorithm=comparison.table["algorithm"].map(format_name)),
        runs=comparison.runs.assign(algorithm=comparison.runs["algorithm"].map(format_name)),
        finished_runs={
            (format_name(label), seed): run
            for (label, seed), run in comparison.finished_runs.items()
        },
    )


def load_values(name: str) -> pd.DataFrame:
    """Return the stored values of a study of many problems, one column per algorithm."""
    values = pd.read_csv(HERE / "data" / name / "values.csv")
    return values.drop(columns=_FORMER, errors="ignore").rename(columns=format_name)


def load_ranks(name: str) -> pd.DataFrame:
    """Return the average ranks of a study of many problems, with tests against the control."""
    return compute_average_ranks(load_values(name), CONTROL)


def load_targets(name: str) -> pd.DataFrame:
    """Return the shares of targets that each algorithm reached in a study of many problems."""
    targets = pd.read_csv(HERE / "data" / name / "targets.csv")
    targets = targets[targets["algorithm"] != _FORMER]
    return targets.assign(algorithm=targets["algorithm"].map(format_name))


def rank_problems(comparisons: Mapping[str, Comparison]) -> pd.DataFrame:
    """Return the average ranks over problems at the end of the runs, with tests."""
    values = compute_problem_values(comparisons)
    ranks = compute_average_ranks(
        values[values["evaluations"] == values["evaluations"].max()], CONTROL
    )
    return ranks[ranks["variables"] == 0]


def list_earlier_studies(names: Sequence[str]) -> list[str]:
    """Return the studies whose stored results are older than recombination."""
    return [
        name
        for name in names
        if min(_read_provenance(path)["written"] for path in (HERE / "data" / name).rglob("prov*"))
        < _RECOMBINATION
    ]


def _read_provenance(path: Path) -> dict[str, Any]:
    data: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return data


def size(name: str) -> Markdown:
    """Return a text with the numbers of evaluations, seeds and runs of a study, and versions."""
    study = read_study(HERE / f"{name}.toml", allow_imports=False)
    provenance = [
        _read_provenance(place / PROVENANCE_FILE) for place in _places(name, study).values()
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


def under_noise() -> dict[float, pd.DataFrame]:
    """Return the average ranks over functions for each noise level of docs/studies/noise.py."""
    rows = pd.read_csv(HERE / "data" / "noise.csv")
    ranks = {}
    for noise, now in rows.groupby("noise"):
        values = now.pivot_table("hypervolume", "problem", "algorithm").rename(columns=format_name)
        values = values.reset_index()
        # All problems have the same size and budget, and each function occurs once.
        values = values.assign(function=values["problem"], variables=0, evaluations=0)
        ranks[noise] = compute_average_ranks(values, CONTROL)
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


def polished() -> Markdown:
    """Return a table of gain and cost of the local refinement, by docs/studies/polished.py."""
    rows = pd.read_csv(HERE / "data" / "polished.csv").fillna(0)
    suffix = rows["stage"].map({"search": "", "polish": ", refined"})
    rows["front"] = rows["algorithm"].map(format_name) + suffix
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


def _places(name: str, study: Study) -> dict[str, Path]:
    """Return the folder with the results of each problem, by label."""
    data = HERE / "data" / name
    if len(study.problems) == 1:
        return {study.problems[0].label: data}
    return {case.label: data / format_folder_name(case.label) for case in study.problems}


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


def ablation() -> Markdown:
    """Return a table of the shares of problems on which the changed algorithms are behind."""
    ranks = compute_average_ranks(load_values("ablation"), "default")
    ranks = ranks[(ranks["variables"] == 0) & ranks["evaluations"].isin((100, 500))]
    shares = ranks.pivot(index="algorithm", columns="evaluations", values="share_control_better")
    shares = shares.drop("default").rename(index=_CHANGES).sort_values(500, ascending=False)
    texts = shares.map("{:.0%}".format).rename(columns="behind after {:.0f}".format)
    return table(texts.rename_axis("change"))


def equalities() -> Markdown:
    """Return a table of the median and range of the results of docs/studies/equalities.py."""
    runs = pd.read_csv(HERE / "data" / "equalities.csv")
    groups = runs.groupby(["problem", "algorithm"], sort=False)["share"]
    texts = groups.agg(lambda x: f"{x.median():.2f} ({x.min():.2f} to {x.max():.2f})")
    return table(texts.unstack()[list(dict.fromkeys(runs["algorithm"]))])
