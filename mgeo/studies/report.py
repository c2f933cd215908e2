"""The page of a comparison, and that of a study of several problems."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from typing import TYPE_CHECKING, Any

import pandas as pd

from mgeo.figures import report_page
from mgeo.figures.comparison.ranks import ranks_figure
from mgeo.studies.labels import folder_name
from mgeo.studies.verdict import beside, verdict

if TYPE_CHECKING:
    from mgeo.studies.comparison import Comparison
    from mgeo.studies.file import Study
    from mgeo.studies.statistics import Friedman


def case_page(study: Study, label: str, comparison: Comparison) -> str:
    """Everything about one problem: verdict, tables, figures, and how it was measured."""
    parts: list[Any] = [f"<h1>{escape(study.title)}</h1>", *_paragraphs(study.about)]
    parts.append(
        f'<p class="note">{escape(label)}; {comparison.n_eval:,} evaluations, '
        f"{len(study.seeds)} seeds; mean ± standard deviation over the runs.</p>"
    )
    parts += _paragraphs(" ".join(verdict(comparison)))
    if study.published is not None:
        parts.append(f"<h2>Beside {escape(study.published.source)}</h2>")
        parts.append(html_table(beside(comparison, study.published)))
    parts += ["<h2>All measures</h2>", html_table(comparison.overview()), *_failures(comparison)]
    parts += ["<h2>Figures</h2>", *comparison.figures().values()]
    tests = comparison.tests()
    pairs, overall = tests.pairs, tests.kruskal_wallis
    if overall is not None:
        first = comparison.indicator().title
        parts += [f"<h2>Pairs, by {first}</h2>", html_table(_readable(pairs).set_index("a"))]
        parts.append(
            '<p class="note">A: probability that a run of the first beats one of the second '
            "(Vargha and Delaney); p: Mann-Whitney, two-sided; with Holm's correction for all "
            f"pairs. Kruskal-Wallis test of all algorithms at once: p = {overall.p:.2g}.</p>"
        )
    parts += ["<h2>How it was measured</h2>", _space(comparison)]
    parts += ["<h2>The study</h2>", f"<pre>{escape(study.text)}</pre>"]
    return report_page(study.title, parts)


def study_page(study: Study, comparisons: Mapping[str, Comparison], ranked: Friedman | None) -> str:
    """Several problems: means of the first indicator each, and ranks over problems."""
    parts: list[Any] = [f"<h1>{escape(study.title)}</h1>", *_paragraphs(study.about)]
    if ranked is not None:
        labels = tuple(contender.label for contender in study.contenders)
        parts.append(ranks_figure(ranked, labels))
    parts += ["<h2>Problems</h2>", html_table(by_problem(comparisons))]
    links = [f'<a href="{folder_name(k)}/report.html">{escape(k)}</a>' for k in comparisons]
    parts += [f"<p>{', '.join(links)}</p>", f"<pre>{escape(study.text)}</pre>"]
    return report_page(study.title, parts)


def by_problem(comparisons: Mapping[str, Comparison]) -> pd.DataFrame:
    """Mean ± sd of each problem's first indicator, problems by algorithms."""
    rows = {
        f"{label} ({c.indicator().title})": c.overview()[c.indicator().title]
        for label, c in comparisons.items()
    }
    return pd.DataFrame(rows).T.rename_axis("problem")


def html_table(table: pd.DataFrame) -> str:
    """A table with its index as the first column."""
    header = [str(table.index.name or ""), *map(str, table.columns)]
    lines = ["<tr>" + "".join(f"<th>{escape(name)}</th>" for name in header) + "</tr>"]
    for name, row in zip(table.index, table.astype(object).to_numpy().tolist(), strict=True):
        cells = "".join(f"<td>{escape(str(value))}</td>" for value in [name, *row])
        lines.append(f"<tr>{cells}</tr>")
    return "<table>\n" + "\n".join(lines) + "\n</table>"


def _readable(pairs: pd.DataFrame) -> pd.DataFrame:
    shown = pairs.assign(
        A=pairs["A"].map("{:.3f}".format),
        p=pairs["p"].map("{:.2g}".format),
        p_holm=pairs["p_holm"].map("{:.2g}".format),
    )
    return shown.rename(columns={"p_holm": "p (Holm)"})


def _failures(comparison: Comparison) -> list[str]:
    failed = comparison.runs[comparison.runs["status"] == "failed"]
    lines = [
        f"<li>{escape(name)}, seed {seed}: {escape(error)}</li>"
        for name, seed, error in zip(
            failed["algorithm"], failed["seed"], failed["error"], strict=True
        )
    ]
    if not lines:
        return []
    return [f'<div class="error">{len(lines)} runs failed:<ul>{"".join(lines)}</ul></div>']


def _space(comparison: Comparison) -> str:
    space = comparison.space
    if space.origin == "objective":
        return "<p>Of a run counts the least feasible value among all its evaluations.</p>"
    if space.origin == "problem":
        where = "in the space of the problem's own indicator_space"
    else:
        box = ", ".join(
            f"{name} from {low:.6g} to {high:.6g}"
            for name, low, high in zip(comparison.objectives, space.ideal, space.nadir, strict=True)
        )
        where = f"with these ranges between 0 and 1: {box}"
    point = ", ".join(f"{value:g}" for value in space.reference_point)
    return (
        f"<p>Fronts are the nondominated points among all evaluations of a run. Indicators are "
        f"taken {escape(where)}; the hypervolume's reference point there is ({point}); IGD+ and "
        f"the additive epsilon refer to {len(space.reference_front)} points.</p>"
    )


def _paragraphs(text: str) -> Sequence[str]:
    return [f"<p>{escape(p.strip())}</p>" for p in text.split("\n\n") if p.strip()]
