"""Comparison of algorithms for mixed variables on the selection of sensors.

    .venv/bin/python docs/studies/suite.py [SEEDS] [FOLDER]

compares the algorithms by `mgeo.compare`, prints the mean and spread of each indicator, and
writes the result of each run to data/suite.csv. FOLDER stores runs as they finish, so that an
interrupted comparison can continue.
"""

import sys
from pathlib import Path

import numpy as np
from mgeo_suite import SensorSuiteProblem
from pymoo.algorithms.moo.nsga2 import RankAndCrowdingSurvival
from pymoo.core.mixed import MixedVariableGA

import mgeo
from mgeo.runs.algorithms import build_algorithm

DATA = Path(__file__).parent / "data" / "suite.csv"
ALGORITHMS = {
    "MGEO directed (ours)": mgeo.MGEODirected(),
    "NSGA-II, mixed operators": build_algorithm("nsga2", {}, SensorSuiteProblem()),
    # The default survival operator is for a single objective.
    "MixedVariableGA": MixedVariableGA(pop_size=50, survival=RankAndCrowdingSurvival()),
    "MGEO canonical": mgeo.MGEOCanonical(tau=1.0, n_walkers=5, bits=8),
    "MGEO var": mgeo.MGEOVar(tau=1.0, n_walkers=5, bits=8),
}
ACCURATE = 0.03  # deg


def study(seeds, folder=None):
    """Compare the algorithms after 10,000 evaluations."""
    problem = SensorSuiteProblem(threads=1)
    return mgeo.compare(
        problem,
        ALGORITHMS,
        10_000,
        seeds,
        folder=folder,
        resume=folder is not None,
        n_jobs=2,
        grid=10,
    )


def cheapest(F):
    """Return the lowest price [kEUR] of a suite whose error is at most `ACCURATE`."""
    return F[F[:, 1] <= ACCURATE, 0].min(initial=np.inf)


if __name__ == "__main__":
    seeds = int(sys.argv[1]) if len(sys.argv) > 1 else 20
    comparison = study(seeds, sys.argv[2] if len(sys.argv) > 2 else None)
    runs = comparison.select_final_rows().set_index(["algorithm", "seed"])
    runs = runs[[each.name for each in comparison.indicators]]
    runs["price"] = {key: cheapest(run.front_F) for key, run in comparison.finished_runs.items()}
    runs.to_csv(DATA, float_format="%.6g", lineterminator="\n")
    print(runs.groupby("algorithm").agg(["mean", "std"]).to_string())
    for indicator in comparison.indicators:
        print(indicator.name, comparison.rank_algorithms(indicator.name))
        print(comparison.test_differences(indicator.name).pairs.to_string(index=False))
