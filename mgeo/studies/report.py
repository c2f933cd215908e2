"""HTML pages of a study and of its problems, and the figures of a study by name."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import pandas as pd
import plotly.graph_objects as go

from mgeo.figures.page import LIBRARY_FILE, render, render_report_page
from mgeo.store.run_folder import REPORT_FILE
from mgeo.studies.aggregation import (
    compute_friedman_test,
    compute_problem_values,
    compute_runtime_distribution,
)
from mgeo.studies.comparison import Comparison
from mgeo.studies.comparison_files import format_folder_names
from mgeo.studies.conclusions import (
    format_conclusions,
    format_control_table,
    list_warnings,
    summarize_study,
)
from mgeo.studies.figures.indicators import (
    draw_anytime_curves,
    draw_critical_difference_diagram,
    draw_runtime_distribution,
)
from mgeo.studies.study_file import Study
from mgeo.studies.summary_tables import (
    build_behind_table,
    build_budget_table,
    build_published_table,
    build_rank_table,
    build_result_table,
)
from mgeo.studies.tables import build_study_table
from mgeo.validation.arguments import format_suggestion


def render_problem_page(study: Study, label: str, comparison: Comparison) -> str:
    """Render the report page of one problem as HTML.

    If the study has several problems, the page loads the plotting library from the folder of the
    study.
    """
    runs, tests = comparison.runs, comparison.test_differences()
    failed = runs[runs["status"] == "failed"]
    control_table = None
    if study.control in comparison.rank_algorithms():
        control_table = format_control_table(comparison, study.control, comparison.indicators)
    summary = render(
        "studies/assets/summary.html",
        study=study,
        title=study.title if len(study.problems) == 1 else f"{study.title}: {label}",
        subtitle=f"{len(comparison.algorithms)} algorithms, {len(study.seeds)} "
        f"seed{'s' if len(study.seeds) > 1 else ''}, {comparison.n_eval:,} evaluations per run",
        overview="" if len(study.problems) == 1 else f"../{REPORT_FILE}",
        conclusions=format_conclusions(comparison, study.control),
        result=build_result_table(comparison),
        warnings=list_warnings({label: comparison}, study.control),
    )
    details = render(
        "studies/assets/problem_details.html",
        study=study,
        comparison=comparison,
        published=build_published_table(study, comparison),
        control_table=control_table,
        further=comparison.format_overview().drop(columns=[i.title for i in comparison.indicators]),
        failed=[f"{row.algorithm}, seed {row.seed}: {row.error}" for row in failed.itertuples()],
    )
    formats = {"A": "{:.3f}".format, "p": "{:.2g}".format, "p_holm": "{:.2g}".format}
    pairs = tests.pairs.assign(**{key: tests.pairs[key].map(to) for key, to in formats.items()})
    method = render(
        "studies/assets/method.html",
        study=study,
        comparison=comparison,
        pairs=pairs.rename(columns={"p_holm": "p (Holm, all pairs)"}).set_index("a"),
        overall=tests.kruskal_wallis,
    )
    library = True if len(study.problems) == 1 else f"../{LIBRARY_FILE}"
    figures = list(comparison.draw_figures().values())
    parts = [summary, *figures[:1], details, *figures[1:], method]
    return render_report_page(study.title, parts, library)


def render_study_page(
    study: Study,
    comparisons: Mapping[str, Comparison],
    ranks: pd.DataFrame,
    errors: Sequence[str] = (),
) -> str:
    """Render the report page over all problems of a study as HTML.

    Parameters
    ----------
    study : Study
        Study of the problems.
    comparisons : mapping of str to Comparison
        Finished comparisons by problem label.
    ranks : DataFrame
        Table of `mgeo.studies.aggregation.compute_average_ranks`.
    errors : sequence of str
        Sentences on problems without a finished run.
    """
    summary = summarize_study(comparisons, study.control)
    problems = build_study_table(comparisons).table
    folders = format_folder_names(p.label for p in study.problems)
    page = render(
        "studies/assets/summary.html",
        study=study,
        title=study.title,
        subtitle=study.format_size(),
        overview="",
        conclusions=[] if summary is None else summary.conclusions,
        result=None if summary is None else build_rank_table(comparisons, summary),
        warnings=[*errors, *list_warnings(comparisons, study.control)],
    )
    details = render(
        "studies/assets/problems.html",
        study=study,
        behind=None if summary is None else build_behind_table(summary),
        problems=problems,
        ranks=build_budget_table(ranks, study),
        links={
            row: f"{folders[label]}/{REPORT_FILE}"
            for row, label in zip(problems.index, comparisons, strict=True)
        },
    )
    figures = _draw_aggregate_figures(comparisons).values()
    return render_report_page(study.title, [page, *figures, details], LIBRARY_FILE)


def draw_study_figures(
    comparisons: Mapping[str, Comparison], names: Sequence[str] = ()
) -> dict[str, go.Figure]:
    """Draw the figures of a study, and return them in a dict keyed by name.

    Names are valid file names. For several problems, the names are ``ranks``, ``targets``, and the
    figures of each problem with the name of its folder, such as ``zdt1-anytime``. The anytime
    figure of each further indicator has its own name, such as ``anytime-igd_plus``.

    Parameters
    ----------
    comparisons : mapping of str to Comparison
        Finished comparisons by problem label.
    names : sequence of str
        Names of the figures to return. A name without the problem selects the figure of all
        problems. Empty for all figures.

    Raises
    ------
    ValueError
        If there is no figure of a name.
    """
    all_figures = _draw_aggregate_figures(comparisons) if len(comparisons) > 1 else {}
    full_names = {name: [name] for name in all_figures}
    folders = format_folder_names(comparisons)
    for label, comparison in comparisons.items():
        prefix = f"{folders[label]}-" if len(comparisons) > 1 else ""
        figures = comparison.draw_figures()
        for indicator in comparison.indicators[1:]:
            figures[f"anytime-{indicator.name}"] = draw_anytime_curves(comparison, indicator.name)
        for name, figure in figures.items():
            all_figures[f"{prefix}{name}"] = figure
            full_names.setdefault(name, []).append(f"{prefix}{name}")
    selection = full_names | {name: [name] for name in all_figures}
    for name in names:
        if name not in selection:
            expected = f"expected {', '.join(full_names)}{format_suggestion(name, selection)}"
            raise ValueError(f"the study has no figure {name!r}: {expected}")
    return {full: all_figures[full] for name in names or all_figures for full in selection[name]}


def _draw_aggregate_figures(comparisons: Mapping[str, Comparison]) -> dict[str, go.Figure]:
    algorithms = next(iter(comparisons.values())).algorithms
    friedman = compute_friedman_test(compute_problem_values(comparisons))
    distribution = compute_runtime_distribution(comparisons)
    figures = {"ranks": draw_critical_difference_diagram(friedman, algorithms)} if friedman else {}
    if len(distribution):
        figures["targets"] = draw_runtime_distribution(distribution, len(comparisons))
    return figures
