"""Table of the problems on which other algorithms are as good as `MGEODirected` or better."""

from collections.abc import Iterator

import pandas as pd
from IPython.display import Markdown
from show import CONTROL, after, count_ahead, load, load_ranks, table, under_noise

from mgeo.studies import Comparison

Row = tuple[str, str, str, str]


def list_limitations() -> Markdown:
    """Return a table with one row per problem: measure, value, and best value of another."""
    titles = ("case", "measure", CONTROL, "other algorithm")
    rows = [*_noise(), *_middle(), *_objectives(), *_variables(), *_constraints(), *_long_runs()]
    return table(pd.DataFrame([*rows, *_local_fronts()], columns=titles).set_index("case"))


def _noise() -> Iterator[Row]:
    wins = count_ahead(under_noise()[0.05], "NSGA-II")
    yield "noisy objectives, WFG", "functions ahead", wins, "NSGA-II"


def _middle() -> Iterator[Row]:
    for label, comparison in load("held-out")[1].items():
        part = comparison.part_indicators[1]
        case = f"{label}, t_end 1,200 to 6,000 s"
        yield _compare(comparison, case, part.name, "NSGA-II", "hypervolume")


def _objectives() -> Iterator[Row]:
    ten = next(c for c in load("objectives")[1].values() if c.problem.n_obj == 10)
    yield _compare(ten, "DTLZ2, 10 objectives", "igd_plus", "NSGA-III", "IGD+ (small is better)")
    five = after("wfg", 5_000, 28)
    for rival in ("SPEA2", "NSGA-III"):
        yield "WFG, 5 objectives", "functions ahead", count_ahead(five, rival), rival


def _variables() -> Iterator[Row]:
    ranks = after("hundred-variables", 200)
    for rival in ("NSGA-II", "SPEA2"):
        yield "100 variables", "problems ahead", count_ahead(ranks, rival), rival


def _constraints() -> Iterator[Row]:
    comparison = load("constraints")[1]["mw1"]
    yield _compare(comparison, "MW1, constraints", "hypervolume", "NSGA-III", "hypervolume")


def _long_runs() -> Iterator[Row]:
    ranks = load_ranks("long-runs")
    ranks = ranks[ranks["variables"] == 0].set_index(["evaluations", "algorithm"])["average_rank"]
    for n in (2_000, 10_000):
        case = f"COCO, {n:,} evaluations per variable"
        own, rival = ranks[n, CONTROL], ranks[n, "COMO-CMA-ES"]
        yield case, "average rank", f"{own:.2f}", f"{rival:.2f} COMO-CMA-ES"


def _local_fronts() -> Iterator[Row]:
    for label in ("zdt4", "dtlz1", "dtlz3"):
        comparison = load("benchmarks")[1][label]
        means = comparison.summarize()[("hypervolume", "mean")].drop(CONTROL)
        case = f"{label.upper()}, 6,000 evaluations"
        yield _compare(comparison, case, "hypervolume", means.idxmax(), "hypervolume")


def _compare(comparison: Comparison, case: str, indicator: str, rival: str, title: str) -> Row:
    means = comparison.summarize()[(indicator, "mean")].map("{:.4f}".format)
    return case, title, means[CONTROL], f"{means[rival]} {rival}"
