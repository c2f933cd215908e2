"""Search robust plans and store the results that docs/validation/robustness.md shows.

``python -m tests.benchmarks.robust SEEDS`` runs the searches of the seeds 1 to SEEDS.
docs/robust.jsonl has a line for each preset, search and seed: CPU time, the predicted front, and
the front of values that hold in 9 of 10 of 200 other Monte Carlo runs. A search that is already in
the file is not repeated.
"""

from __future__ import annotations

import dataclasses
import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from mgeo_attitude import AttitudeManeuverProblem
from mgeo_attitude.scenario import MonteCarloSettings
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.core.algorithm import Algorithm
from pymoo.indicators.hv import HV
from pymoo.optimize import minimize

from mgeo import MGEODirected, MGEOStaged
from mgeo.evaluation.dominance import find_front_rows

from ..three import three
from .pages import DOCS, add_result, read_results

DATA = DOCS / "robust.jsonl"
PRESETS = ("paper", "cubesat_6u")
#: Seed of the Monte Carlo runs that evaluate the fronts. No search uses it.
EVALUATION_SEED = 999
#: Monte Carlo runs that screen a nominal front. More runs would leave less time for the search.
SCREENING = MonteCarloSettings(n_runs=256, quantile=0.95)
#: Numbers of evaluations with which a nominal search, and a search with 16 Monte Carlo runs per
#: design, take as long as the robust search.
N_NOMINAL_EVALUATIONS = {"paper": 105_000, "cubesat_6u": 140_000}
N_MONTE_CARLO_EVALUATIONS = {"paper": 20_000, "cubesat_6u": 19_000}

Front = tuple[np.ndarray, np.ndarray]
Search = Callable[[AttitudeManeuverProblem, int], Front]


def run_search(problem: AttitudeManeuverProblem, algorithm: Algorithm, n: int, seed: int) -> Front:
    """Return the designs X and objectives F of the front after n evaluations."""
    result = minimize(problem, algorithm, ("n_eval", n), seed=seed)
    return result.X, result.F


def robust(problem: AttitudeManeuverProblem, seed: int) -> Front:
    """Return the front of the search of ``mgeo solve attitude --robust``."""
    return run_search(problem.to_robust(), MGEOStaged(), 60_000, seed)


def screened(problem: AttitudeManeuverProblem, seed: int) -> Front:
    """Return the plans of a nominal front that are nondominated in Monte Carlo runs, for equal CPU
    time.
    """
    X, _ = run_search(problem, MGEODirected(), N_NOMINAL_EVALUATIONS[problem.scenario.name], seed)
    screening = dataclasses.replace(problem.scenario, monte_carlo=SCREENING)
    F = AttitudeManeuverProblem(screening).evaluate(X, return_values_of=["F"])
    rows = find_front_rows(F)
    return X[rows], F[rows]


def nsga2(problem: AttitudeManeuverProblem, seed: int) -> Front:
    """Return the front of NSGA-II with 16 Monte Carlo runs of each design, for equal CPU time."""
    monte_carlo_problem = AttitudeManeuverProblem(problem.scenario, n_runs=16)
    return run_search(
        monte_carlo_problem,
        NSGA2(pop_size=100),
        N_MONTE_CARLO_EVALUATIONS[problem.scenario.name],
        seed,
    )


def nominal(problem: AttitudeManeuverProblem, seed: int) -> Front:
    """Return the front of a search without random errors."""
    return run_search(problem, MGEODirected(), 60_000, seed)


SEARCHES: dict[str, Search] = {
    "robust": robust,
    "screened": screened,
    "NSGA-II": nsga2,
    "nominal": nominal,
}


def evaluate_search(preset: str, search: str, seed: int) -> dict[str, Any]:
    """Run a search and return its result as a dict that becomes a line of the file."""
    problem = AttitudeManeuverProblem(three(preset))
    start = time.process_time()
    X, F = SEARCHES[search](problem, seed)
    seconds = time.process_time() - start
    monte_carlo = (
        problem.view(X)
        .compare_with_monte_carlo(seed=EVALUATION_SEED)
        .filter(regex="^Monte Carlo (?!/)")
        .to_numpy()
    )
    ratio = monte_carlo[:, 0] / F[:, 0]
    monte_carlo_front = monte_carlo[find_front_rows(monte_carlo)]
    return {
        "key": [preset, search, seed],
        "processor_s": round(seconds, 1),
        "plans": len(X),
        "predicted": compute_hypervolume(problem, F),
        "monte_carlo": compute_hypervolume(problem, monte_carlo),
        "nondominated": len(monte_carlo_front),
        "ratio": [float(np.median(ratio)), float(ratio.max())],
        "overrun": float((ratio > 1.2).mean()),
        "fronts": [round_values(F[find_front_rows(F)]), round_values(monte_carlo_front)]
        if seed == 1
        else [],
    }


def compute_hypervolume(problem: AttitudeManeuverProblem, F: np.ndarray) -> float:
    """Return the hypervolume in the problem's indicator space, for the reference point (1, 1)."""
    points = problem.map_to_indicator_space(F)
    return float(HV(ref_point=np.ones(2))(points[(points < 1.0).all(axis=1)]))


def round_values(F: np.ndarray) -> list[list[float]]:
    """Return values rounded to five significant digits."""
    return [[float(f"{value:.5g}") for value in row] for row in F]


def main() -> None:
    stored = [each["key"] for each in read_results(DATA)]
    for seed in range(1, int(sys.argv[1]) + 1):
        for search in SEARCHES:
            for preset in PRESETS:
                if [preset, search, seed] not in stored:
                    add_result(DATA, evaluate_search(preset, search, seed))


if __name__ == "__main__":
    main()
