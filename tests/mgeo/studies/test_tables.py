from itertools import combinations
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from mgeo.studies.conclusions import format_published_table
from mgeo.studies.report import draw_study_figures
from mgeo.studies.schema import PublishedTable
from mgeo.studies.tables import MarkedTable, build_problem_table, build_study_table, format_markdown

from .samples import build_comparison, build_final_comparison


def build_shifted_comparison(**shifts):
    """Return a comparison of algorithms whose final hypervolumes differ by the given shifts."""
    rng = np.random.default_rng(5)
    return build_final_comparison(
        {k: 0.5 + shift + 0.02 * rng.standard_normal(12) for k, shift in shifts.items()}
    )


@pytest.fixture
def comparison():
    return build_shifted_comparison(near=-0.01, best_1=0.0, far=-0.2)


def test_best_mean_is_bold_and_equivalent_means_are_marked(comparison):
    values = {
        name: rows["hypervolume"].to_numpy() for name, rows in comparison.table.groupby("algorithm")
    }
    means = {name: each.mean() for name, each in values.items()}
    best = max(means, key=means.get)
    pairs = list(combinations(values, 2))
    p = [stats.mannwhitneyu(values[a], values[b]).pvalue for a, b in pairs]
    rejected, alpha = set(), 0.05
    for place, i in enumerate(np.argsort(p)):  # Holm (1979) stops at the first accepted hypothesis.
        if p[i] > alpha / (len(p) - place):
            break
        rejected.add(pairs[i])
    equivalent = {n for n in values if n != best and not {(n, best), (best, n)} & rejected}
    assert equivalent == {"near"}
    table = build_problem_table(comparison)
    for column in ("hypervolume", "IGD+", "additive epsilon"):
        assert {row for row, c in table.best if c == column} == {best} == {"best_1"}
        assert {row for row, c in table.equivalent if c == column} == equivalent
    shown = comparison.format_overview()["hypervolume"]
    lines = table.to_markdown().splitlines()
    assert f"| best_1 | 12 | **{shown['best_1']}** |" in lines[3]
    assert f"| near | 12 | {shown['near']} † |" in lines[2]
    assert "†" not in lines[4]
    assert lines[-1].startswith("Mean ± standard deviation of the runs. Bold: the best mean. †: ")
    text = comparison.to_latex()
    cell = shown["best_1"].replace("±", r"$\pm$")
    assert rf"best\_1 & 12 & \textbf{{{cell}}} &" in text
    near = shown["near"].replace("±", r"$\pm$")
    assert rf"near & 12 & {near} $^\dagger$ &" in text
    assert text.index(r"\end{tabular}") < text.index(r"{\footnotesize Mean $\pm$ standard")
    assert "at 5 \\%.}\n" in text


def test_study_table_is_marked_in_each_row(comparison):
    second = build_shifted_comparison(near=0.1, best_1=0.0, far=-0.2)
    table = build_study_table({"one": comparison, "two": second})
    assert list(table.table.index) == ["one (hypervolume)", "two (hypervolume)"]
    assert set(table.best) == {("one (hypervolume)", "best_1"), ("two (hypervolume)", "near")}
    assert set(table.equivalent) == {("one (hypervolume)", "near")}
    assert (
        table.table.loc["two (hypervolume)", "far"]
        == second.format_overview().loc["far", "hypervolume"]
    )
    assert table.to_latex().count(r"\textbf") == 2


def test_special_characters_of_tables_are_escaped():
    table = pd.DataFrame({"50 %": ["a|b<c"]}, index=pd.Index(["σ ^ {1} \\"], name="x & y"))
    assert format_markdown(table) == "| x & y | 50 % |\n| --- | ---: |\n| σ ^ {1} \\ | a\\|b<c |\n"
    text = MarkedTable(table, (), ()).to_latex()
    assert r"x \& y & 50 \% \\" in text
    assert (
        r"$\sigma$ \textasciicircum{} \{1\} \textbackslash{} & a\textbar{}b\textless{}c \\" in text
    )


@pytest.mark.parametrize(("evaluations", "shown"), [(None, True), (100, True), (59_760, False)])
def test_published_values_are_shown_for_equal_budget_only(comparison, evaluations, shown):
    published = PublishedTable(
        source="x", evaluations=evaluations, table={"best_1": {"points": 7.0}}
    )
    table = format_published_table(SimpleNamespace(published=published), comparison)
    assert (table is not None) == shown
    if shown:
        assert table.loc["best_1", "points: published"] == "7"
    assert format_published_table(SimpleNamespace(published=None), comparison) is None


@pytest.mark.slow
def test_figures_of_study_are_selected_by_name():
    comparison = build_comparison()
    comparison.runs[["algorithm", "seed"]] = comparison.table[
        ["algorithm", "seed"]
    ].drop_duplicates()
    comparisons = {"one": comparison, "two": comparison}
    assert {"ranks", "targets", "one-anytime-igd_plus", "two-panels"} < set(
        draw_study_figures(comparisons)
    )
    chosen = draw_study_figures(comparisons, ["anytime", "two-boxes"])
    assert list(chosen) == ["one-anytime", "two-anytime", "two-boxes"]
    with pytest.raises(ValueError, match=r"no figure 'rank': expected ranks, .*mean 'ranks'\?"):
        draw_study_figures(comparisons, ["rank"])
