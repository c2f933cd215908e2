"""Tables for a paper: what is bold and what is marked, in both languages."""

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

from .samples import comparison as made_by_hand
from .samples import final


def comparison(**shifts):
    """Runs of algorithms whose values differ by these shifts."""
    rng = np.random.default_rng(5)
    return final({k: 0.5 + shift + 0.02 * rng.standard_normal(12) for k, shift in shifts.items()})


@pytest.fixture
def three():
    return comparison(near=-0.01, best_1=0.0, far=-0.2)


def test_the_best_mean_is_bold_and_what_does_not_differ_from_it_is_marked(three):
    """Held against the test and Holm's correction, each written out here."""
    values = {
        name: rows["hypervolume"].to_numpy() for name, rows in three.table.groupby("algorithm")
    }
    means = {name: each.mean() for name, each in values.items()}
    best = max(means, key=means.get)
    pairs = list(combinations(values, 2))
    p = [stats.mannwhitneyu(values[a], values[b]).pvalue for a, b in pairs]
    rejected, alpha = set(), 0.05
    for place, i in enumerate(np.argsort(p)):  # Holm 1979: stop at the first that is kept
        if p[i] > alpha / (len(p) - place):
            break
        rejected.add(pairs[i])
    alike = {n for n in values if n != best and not {(n, best), (best, n)} & rejected}
    assert alike == {"near"}
    table = build_problem_table(three)
    for column in ("hypervolume", "IGD+", "additive epsilon"):
        assert {row for row, c in table.best if c == column} == {best} == {"best_1"}
        assert {row for row, c in table.equivalent if c == column} == alike
    shown = three.format_overview()["hypervolume"]
    lines = table.to_markdown().splitlines()
    assert f"| best_1 | 12 | **{shown['best_1']}** |" in lines[3]
    assert f"| near | 12 | {shown['near']} † |" in lines[2]
    assert "†" not in lines[4]
    assert lines[-1].startswith("Mean ± standard deviation of the runs. Bold: the best mean. †: ")
    text = three.to_latex()
    cell = shown["best_1"].replace("±", r"$\pm$")
    assert rf"best\_1 & 12 & \textbf{{{cell}}} &" in text
    near = shown["near"].replace("±", r"$\pm$")
    assert rf"near & 12 & {near} $^\dagger$ &" in text
    assert text.index(r"\end{tabular}") < text.index(r"{\footnotesize Mean $\pm$ standard")
    assert "at 5 \\%.}\n" in text


def test_all_problems_in_one_table(three):
    """Each row is marked by itself."""
    other = comparison(near=0.1, best_1=0.0, far=-0.2)
    table = build_study_table({"one": three, "two": other})
    assert list(table.table.index) == ["one (hypervolume)", "two (hypervolume)"]
    assert set(table.best) == {("one (hypervolume)", "best_1"), ("two (hypervolume)", "near")}
    assert set(table.equivalent) == {("one (hypervolume)", "near")}
    assert (
        table.table.loc["two (hypervolume)", "far"]
        == other.format_overview().loc["far", "hypervolume"]
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
def test_published_values_are_shown_where_the_budget_is_theirs(three, evaluations, shown):
    published = PublishedTable(
        source="x", evaluations=evaluations, table={"best_1": {"points": 7.0}}
    )
    found = format_published_table(SimpleNamespace(published=published), three)
    assert (found is not None) == shown
    if shown:
        assert found.loc["best_1", "points: published"] == "7"
    assert format_published_table(SimpleNamespace(published=None), three) is None


@pytest.mark.slow
def test_figures_of_a_study_are_chosen_by_name():
    made = made_by_hand()
    made.runs[["algorithm", "seed"]] = made.table[["algorithm", "seed"]].drop_duplicates()
    found = {"one": made, "two": made}
    assert {"ranks", "targets", "one-anytime-igd_plus", "two-panels"} < set(
        draw_study_figures(found)
    )
    chosen = draw_study_figures(found, ["anytime", "two-boxes"])
    assert list(chosen) == ["one-anytime", "two-anytime", "two-boxes"]
    with pytest.raises(ValueError, match=r"no figure 'rank': expected ranks, .*mean 'ranks'\?"):
        draw_study_figures(found, ["rank"])
