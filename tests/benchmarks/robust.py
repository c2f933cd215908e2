"""``python -m tests.benchmarks.robust SEEDS``: searches of plans that keep their promise.

Appends a line to docs/robust.jsonl for each preset, search and seed that is not in it yet, with the
processor's seconds, what the front promises, and what 9 of 10 of 200 other flights keep of it.
Run it in the repository's root; `tests.benchmarks.robust_document` makes the page's table of it.
"""

from __future__ import annotations

import dataclasses
import json
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from mgeo_attitude import AttitudeManeuverProblem
from mgeo_attitude.scenario import FlightErrors
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.core.algorithm import Algorithm
from pymoo.indicators.hv import HV
from pymoo.optimize import minimize

from mgeo import MGEODirected, MGEOStaged
from mgeo.evaluation.dominance import front_rows

from ..three import three

ROOT = Path(__file__).parents[2]
DATA = ROOT / "docs" / "robust.jsonl"
PRESETS = ("paper", "cubesat_6u")
#: Seed of the flights that judge, which no search has.
JUDGES = 999
#: The flights of a front that is screened; with more the search had to be shorter.
SCREENING = FlightErrors(count=256, quantile=0.95)
#: Evaluations of an exact search that takes as long as the robust one, and designs of one in which
#: each is flown 16 times.
EXACT = {"paper": 105_000, "cubesat_6u": 140_000}
FLOWN = {"paper": 20_000, "cubesat_6u": 19_000}

Front = tuple[np.ndarray, np.ndarray]
Search = Callable[[AttitudeManeuverProblem, int], Front]


def found(problem: AttitudeManeuverProblem, algorithm: Algorithm, n: int, seed: int) -> Front:
    """X and F of a run of n evaluations."""
    result = minimize(problem, algorithm, ("n_eval", n), seed=seed)
    return result.X, result.F


def robust(exact: AttitudeManeuverProblem, seed: int) -> Front:
    """What ``mgeo solve attitude --robust`` does."""
    return found(exact.robust(), MGEOStaged(), 60_000, seed)


def screened(exact: AttitudeManeuverProblem, seed: int) -> Front:
    """An exact search as long, and of its front what is nondominated over flights."""
    X, _ = found(exact, MGEODirected(), EXACT[exact.scenario.name], seed)
    flown = dataclasses.replace(exact.scenario, flight=SCREENING)
    F = AttitudeManeuverProblem(flown).evaluate(X, return_values_of=["F"])
    rows = front_rows(F)
    return X[rows], F[rows]


def nsga2(exact: AttitudeManeuverProblem, seed: int) -> Front:
    """With 16 flights of each design, as long."""
    flown = AttitudeManeuverProblem(exact.scenario, flights=16)
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
    kept = exact.view(X).promises(seed=JUDGES).filter(regex="^kept (?!/)").to_numpy()
    ratio = kept[:, 0] / F[:, 0]
    safe = kept[front_rows(kept)]
    return {
        "key": [preset, search, seed],
        "processor_s": round(spent, 1),
        "plans": len(X),
        "promised": hypervolume(exact, F),
        "kept": hypervolume(exact, kept),
        "nondominated": len(safe),
        "ratio": [float(np.median(ratio)), float(ratio.max())],
        "late": float((ratio > 1.2).mean()),
        "fronts": [digits(F[front_rows(F)]), digits(safe)] if seed == 1 else [],
    }


def hypervolume(problem: AttitudeManeuverProblem, F: np.ndarray) -> float:
    """In the problem's indicator space, of the reference point (1, 1)."""
    points = problem.indicator_space(F)
    return float(HV(ref_point=np.ones(2))(points[(points < 1.0).all(axis=1)]))


def digits(F: np.ndarray) -> list[list[float]]:
    """Numbers of five digits."""
    return [[float(f"{value:.5g}") for value in row] for row in F]


def stored() -> list[dict[str, Any]]:
    """The lines of the file."""
    lines = DATA.read_text(encoding="utf-8").splitlines() if DATA.exists() else []
    return [json.loads(line) for line in lines]


def main() -> None:
    known = [each["key"] for each in stored()]
    for seed in range(1, int(sys.argv[1]) + 1):
        for search in SEARCHES:
            for preset in PRESETS:
                if [preset, search, seed] not in known:
                    line = json.dumps(row(preset, search, seed))
                    with DATA.open("a", encoding="utf-8") as file:
                        file.write(line + "\n")


if __name__ == "__main__":
    main()
