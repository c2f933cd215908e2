"""The page of a comparison, and that of a study of several problems."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import pandas as pd

from mgeo.figures import report_page
from mgeo.figures.page import render
from mgeo.studies.figures.ranks import ranks_figure
from mgeo.studies.labels import folder_name
from mgeo.studies.verdict import beside, verdict

if TYPE_CHECKING:
    from mgeo.studies.comparison import Comparison
    from mgeo.studies.file import Study
    from mgeo.studies.statistics import Friedman


def case_page(study: Study, label: str, comparison: Comparison) -> str:
    """Everything about one problem: verdict, tables, figures, and how it was measured."""
    runs, tests = comparison.runs, comparison.tests()
    results = render(
        "studies/assets/results.html",
        study=study,
        label=label,
        comparison=comparison,
        verdict=" ".join(verdict(comparison)),
        published=beside(comparison, study.published) if study.published else None,
        failed=runs[runs["status"] == "failed"].to_dict("records"),
    )
    method = render(
        "studies/assets/method.html",
        study=study,
        comparison=comparison,
        pairs=_readable(tests.pairs).set_index("a"),
        overall=tests.kruskal_wallis,
    )
    return report_page(study.title, [results, *comparison.figures().values(), method])


def study_page(study: Study, comparisons: Mapping[str, Comparison], ranked: Friedman | None) -> str:
    """Several problems: means of the first indicator each, and ranks over problems."""
    labels = tuple(contender.label for contender in study.contenders)
    problems = render(
        "studies/assets/problems.html",
        study=study,
        problems=by_problem(comparisons),
        folders={label: folder_name(label) for label in comparisons},
    )
    figures = [] if ranked is None else [ranks_figure(ranked, labels)]
    head = render("studies/assets/head.html", study=study)
    return report_page(study.title, [head, *figures, problems])


def by_problem(comparisons: Mapping[str, Comparison]) -> pd.DataFrame:
    """Mean ± sd of each problem's first indicator, problems by algorithms."""
    rows = {
        f"{label} ({c.indicator().title})": c.overview()[c.indicator().title]
        for label, c in comparisons.items()
    }
    return pd.DataFrame(rows).T.rename_axis("problem")


def _readable(pairs: pd.DataFrame) -> pd.DataFrame:
    shown = pairs.assign(
        A=pairs["A"].map("{:.3f}".format),
        p=pairs["p"].map("{:.2g}".format),
        p_holm=pairs["p_holm"].map("{:.2g}".format),
    )
    return shown.rename(columns={"p_holm": "p (Holm)"})
