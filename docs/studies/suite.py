"""MGEODirected and what else takes mixed variables, on the choice of sensors.

    .venv/bin/python docs/studies/suite.py [SEEDS] [FOLDER]

compares them by `mgeo.compare`, prints what docs/suite.md quotes, and writes what each run found to
data/suite.csv. FOLDER stores runs as they finish; an interrupted comparison continues there.
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
    # its own survival is that of a single objective
    "MixedVariableGA": MixedVariableGA(pop_size=50, survival=RankAndCrowdingSurvival()),
    "MGEO canonical": mgeo.MGEOCanonical(tau=1.0, n_walkers=5, bits=8),
    "MGEO var": mgeo.MGEOVar(tau=1.0, n_walkers=5, bits=8),
}
ACCURATE = 0.03  # deg


def study(seeds, folder=None):
    """The comparison at 10,000 evaluations."""
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
    """Least price [kEUR] of what is as accurate as `ACCURATE`."""
    return F[F[:, 1] <= ACCURATE, 0].min(initial=np.inf)


if __name__ == "__main__":
    seeds = int(sys.argv[1]) if len(sys.argv) > 1 else 20
    found = study(seeds, sys.argv[2] if len(sys.argv) > 2 else None)
    runs = found.select_final_rows().set_index(["algorithm", "seed"])
    runs = runs[[each.name for each in found.indicators]]
    runs["price"] = {key: cheapest(run.front_F) for key, run in found.finished_runs.items()}
    runs.to_csv(DATA, float_format="%.6g", lineterminator="\n")
    print(runs.groupby("algorithm").agg(["mean", "std"]).to_string())
    for indicator in found.indicators:
        print(indicator.name, found.rank_algorithms(indicator.name))
        print(found.test_differences(indicator.name).pairs.to_string(index=False))
