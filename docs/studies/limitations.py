"""Table of the problems on which other algorithms are as good as `MGEODirected` or better."""

from collections.abc import Iterator
from typing import NamedTuple

import pandas as pd
from IPython.display import Markdown
from show import after, count_ahead, table
from show_single import under_noise
from stored_studies import CONTROL, load, load_ranks

from mgeo.studies import Comparison


class Case(NamedTuple):
    """Mean result of `MGEODirected` and of another algorithm in one case, formatted.

    `is_ahead` is True if `MGEODirected` is better, so that the case is no limitation.
    """

    case: str
    measure: str
    own: str
    other: str
    is_ahead: bool


def list_limitations() -> Markdown:
    """Return a table with one row per case in which `MGEODirected` is not ahead."""
    titles = ("case", "measure", CONTROL, "other algorithm")
    cases = [*_noise(), *_middle(), *_objectives(), *_variables(), *_constraints(), *_long_runs()]
    rows = [each[:4] for each in (*cases, *_local_fronts()) if not each.is_ahead]
    return table(pd.DataFrame(rows, columns=titles).set_index("case"))


def _noise() -> Iterator[Case]:
    yield _count("noisy objectives, WFG", "functions ahead", under_noise()[0.05], "NSGA-II")


def _middle() -> Iterator[Case]:
    for label, comparison in load("held-out")[1].items():
        part = comparison.part_indicators[1]
        case = f"{label}, t_end 1,200 to 6,000 s"
        yield _compare(comparison, case, part.name, "NSGA-II", "hypervolume")


def _objectives() -> Iterator[Case]:
    ten = next(c for c in load("objectives")[1].values() if c.problem.n_obj == 10)
    title = "IGD+ (small is better)"
    yield _compare(ten, "DTLZ2, 10 objectives", "igd_plus", "NSGA-III", title, is_small_better=True)
    five = after("wfg", 5_000, 28)
    for rival in ("SPEA2", "NSGA-III"):
        yield _count("WFG, 5 objectives", "functions ahead", five, rival)


def _variables() -> Iterator[Case]:
    ranks = after("hundred-variables", 200)
    for rival in ("NSGA-II", "SPEA2"):
        yield _count("100 variables", "problems ahead", ranks, rival)


def _constraints() -> Iterator[Case]:
    comparison = load("constraints")[1]["mw1"]
    yield _compare(comparison, "MW1, constraints", "hypervolume", "NSGA-III", "hypervolume")


def _long_runs() -> Iterator[Case]:
    ranks = load_ranks("long-runs")
    ranks = ranks[ranks["variables"] == 0].set_index(["evaluations", "algorithm"])
    for n in (2_000, 10_000):
        own, rival = ranks.loc[(n, CONTROL)], ranks.loc[(n, "COMO-CMA-ES")]
        yield Case(
            f"{own['functions']:.0f} functions of COCO, {n:,} evaluations per variable",
            "average rank",
            f"{own['average_rank']:.2f}",
            f"{rival['average_rank']:.2f} COMO-CMA-ES",
            bool(own["average_rank"] < rival["average_rank"]),
        )


def _local_fronts() -> Iterator[Case]:
    for label in ("zdt4", "dtlz1", "dtlz3"):
        comparison = load("benchmarks")[1][label]
        means = comparison.summarize()[("hypervolume", "mean")].drop(CONTROL)
        case = f"{label.upper()}, 6,000 evaluations"
        yield _compare(comparison, case, "hypervolume", means.idxmax(), "hypervolume")


def _count(case: str, title: str, ranks: pd.DataFrame, rival: str) -> Case:
    """Return the case of a set of functions, on which `MGEODirected` is ahead of a rival if it is
    ahead on more than half of them.
    """
    row = ranks[ranks["algorithm"] == rival].iloc[0]
    is_ahead = row["n_functions_control_better"] > row["functions"] / 2
    return Case(case, title, count_ahead(ranks, rival), rival, bool(is_ahead))


def _compare(
    comparison: Comparison,
    case: str,
    indicator: str,
    rival: str,
    title: str,
    is_small_better: bool = False,
) -> Case:
    """Return the case of one problem, compared by the means of an indicator."""
    means = comparison.summarize()[(indicator, "mean")]
    own, other = means[CONTROL], means[rival]
    is_ahead = own < other if is_small_better else own > other
    return Case(case, title, f"{own:.4f}", f"{other:.4f} {rival}", bool(is_ahead))
