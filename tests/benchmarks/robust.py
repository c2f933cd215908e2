"""Search robust plans and write the table and the picture of docs/robust.md.

    python -m tests.benchmarks.robust SEEDS

docs/robust.jsonl has a line for each preset, search and seed: CPU time, the predicted front, and
the front that holds in 9 of 10 of 200 other Monte Carlo runs. A search that it has is not repeated.
"""

from __future__ import annotations

import dataclasses
import sys
import time
from collections.abc import Callable, Iterator
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from mgeo_attitude import AttitudeManeuverProblem
from mgeo_attitude.scenario import MonteCarloSettings
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.core.algorithm import Algorithm
from pymoo.indicators.hv import HV
from pymoo.optimize import minimize

from mgeo import MGEODirected, MGEOStaged
from mgeo.evaluation.dominance import find_front_rows
from mgeo.studies.statistics import holm_correction, mann_whitney_p_value

from ..three import three
from .pages import DOCS, add_result, read_results, write_table

DATA = DOCS / "robust.jsonl"
PAGE, PICTURE = DOCS / "robust.md", DOCS / "images" / "robust.svg"
PRESETS = ("paper", "cubesat_6u")
#: Seed of the flights that judge, which no search has.
JUDGES = 999
#: The flights of a front that is screened; with more the search had to be shorter.
SCREENING = MonteCarloSettings(n_runs=256, quantile=0.95)
#: Evaluations of an exact search that takes as long as the robust one, and designs of one in which
#: each is flown 16 times.
EXACT = {"paper": 105_000, "cubesat_6u": 140_000}
FLOWN = {"paper": 20_000, "cubesat_6u": 19_000}
#: What the picture shows of whom: promised and kept.
SHOWN = {"nominal": "#D55E00", "robust": "#0072B2"}
#: Fewer seeds than this have no test.
LEAST = 5

Rows = list[dict[str, Any]]
Front = tuple[np.ndarray, np.ndarray]
Search = Callable[[AttitudeManeuverProblem, int], Front]


def found(problem: AttitudeManeuverProblem, algorithm: Algorithm, n: int, seed: int) -> Front:
    """X and F of a run of n evaluations."""
    result = minimize(problem, algorithm, ("n_eval", n), seed=seed)
    return result.X, result.F


def robust(exact: AttitudeManeuverProblem, seed: int) -> Front:
    """What ``mgeo solve attitude --robust`` does."""
    return found(exact.to_robust(), MGEOStaged(), 60_000, seed)


def screened(exact: AttitudeManeuverProblem, seed: int) -> Front:
    """An exact search as long, and of its front what is nondominated over flights."""
    X, _ = found(exact, MGEODirected(), EXACT[exact.scenario.name], seed)
    flown = dataclasses.replace(exact.scenario, monte_carlo=SCREENING)
    F = AttitudeManeuverProblem(flown).evaluate(X, return_values_of=["F"])
    rows = find_front_rows(F)
    return X[rows], F[rows]


def nsga2(exact: AttitudeManeuverProblem, seed: int) -> Front:
    """With 16 flights of each design, as long."""
    flown = AttitudeManeuverProblem(exact.scenario, n_runs=16)
    return found(flown, NSGA2(pop_size=100), FLOWN[exact.scenario.name], seed)


def nominal(exact: AttitudeManeuverProblem, seed: int) -> Front:
    """As if plans were flown exactly."""
    return found(exact, MGEODirected(), 60_000, seed)


SEARCHES: dict[str, Search] = {
    "robust": robust,
    "screened": screened,
    "NSGA-II": nsga2,
    "nominal": nominal,
}


def row(preset: str, search: str, seed: int) -> dict[str, Any]:
    """A line of the file."""
    exact = AttitudeManeuverProblem(three(preset))
    start = time.process_time()
    X, F = SEARCHES[search](exact, seed)
    spent = time.process_time() - start
    kept = (
        exact.view(X).compare_with_monte_carlo(seed=JUDGES).filter(regex="^kept (?!/)").to_numpy()
    )
    ratio = kept[:, 0] / F[:, 0]
    safe = kept[find_front_rows(kept)]
    return {
        "key": [preset, search, seed],
        "processor_s": round(spent, 1),
        "plans": len(X),
        "promised": hypervolume(exact, F),
        "kept": hypervolume(exact, kept),
        "nondominated": len(safe),
        "ratio": [float(np.median(ratio)), float(ratio.max())],
        "late": float((ratio > 1.2).mean()),
        "fronts": [digits(F[find_front_rows(F)]), digits(safe)] if seed == 1 else [],
    }


def hypervolume(problem: AttitudeManeuverProblem, F: np.ndarray) -> float:
    """In the problem's indicator space, of the reference point (1, 1)."""
    points = problem.map_to_indicator_space(F)
    return float(HV(ref_point=np.ones(2))(points[(points < 1.0).all(axis=1)]))


def digits(F: np.ndarray) -> list[list[float]]:
    """Numbers of five digits."""
    return [[float(f"{value:.5g}") for value in row] for row in F]


def of(rows: Rows, preset: str, search: str) -> Rows:
    """Those of a preset and search."""
    return [row for row in rows if row["key"][:2] == [preset, search]]


def column(rows: Rows, name: str) -> np.ndarray:
    """A number of each row."""
    return np.array([row[name] for row in rows])


def table(rows: Rows) -> Iterator[str]:
    """A line for each preset and search."""
    yield (
        "| preset | search | CPU time, least [s] | hypervolume predicted | kept "
        "| kept / predicted t_end: median | greatest | more than 20 % late |"
    )
    yield "| --- | --- | ---: | ---: | ---: | ---: | ---: | ---: |"
    for preset in PRESETS:
        for search in SEARCHES:
            if not (each := of(rows, preset, search)):
                continue
            median, greatest = column(each, "ratio").T
            late = 100.0 * column(each, "late").mean()
            yield (
                f"| {preset} | {search} | {column(each, 'processor_s').min():.0f} "
                f"| {column(each, 'promised').mean():.4f} | {column(each, 'kept').mean():.4f} "
                f"| {np.mean(median):.2f} | {greatest.max():.2f} | {late:.1f} % |"
            )


def tests(rows: Rows) -> Iterator[str]:
    """p of what is kept, against the robust search, by Holm for the searches of a preset."""
    for preset in PRESETS:
        kept = {search: column(of(rows, preset, search), "kept") for search in SEARCHES}
        if min(map(len, kept.values())) < LEAST:
            continue
        others = [search for search in kept if search != "robust"]
        p = holm_correction([mann_whitney_p_value(kept["robust"], kept[each]) for each in others])
        yield f"{preset}: " + ", ".join(
            f"{search} p = {value:.2g}" for search, value in zip(others, p, strict=True)
        )


def draw(rows: Rows) -> None:
    """Write the picture: fronts of seed 1, as promised and as kept."""
    mpl.rcParams["svg.hashsalt"] = "robust"
    figure = Figure(figsize=(10.0, 4.2), layout="constrained")
    for axes, preset in zip(figure.subplots(1, 2), PRESETS, strict=True):
        for search, color in SHOWN.items():
            for row in of(rows, preset, search):
                for front, style, what in zip(
                    row["fronts"], (":", "-"), ("predicted", "0.9-quantile"), strict=False
                ):
                    time, trace = np.array(front).T
                    label = f"{search}, {what}"
                    axes.step(time, trace, style, color=color, where="post", label=label)
        axes.set(title=preset, yscale="log", xlabel="t_end [s]", ylabel="trace [-]")
        axes.legend(frameon=False)
    figure.savefig(PICTURE, metadata={"Date": None})


def main() -> None:
    known = [each["key"] for each in read_results(DATA)]
    for seed in range(1, int(sys.argv[1]) + 1):
        for search in SEARCHES:
            for preset in PRESETS:
                if [preset, search, seed] not in known:
                    add_result(DATA, row(preset, search, seed))
    rows = read_results(DATA)
    print(*tests(rows), sep="\n")
    write_table(PAGE, "searches", "\n".join(table(rows)))
    draw(rows)


if __name__ == "__main__":
    main()
