"""MGEODirected and what else takes mixed variables, on the choice of sensors.

    .venv/bin/python docs/studies/suite.py [SEEDS] [FOLDER]

compares them by `mgeo.compare` and prints means, tests and the order.
"""

import sys

from mgeo_suite import SensorSuiteProblem
from pymoo.algorithms.moo.nsga2 import NSGA2, RankAndCrowdingSurvival
from pymoo.core.mixed import MixedVariableGA

import mgeo

ALGORITHMS = {
    "MGEO directed (ours)": mgeo.MGEODirected(),
    "NSGA-II, mixed operators": NSGA2(pop_size=100),
    # its own survival is that of a single objective
    "MixedVariableGA": MixedVariableGA(pop_size=50, survival=RankAndCrowdingSurvival()),
    "MGEO canonical": mgeo.MGEOCanonical(tau=1.0, n_walkers=5, bits=8),
    "MGEO var": mgeo.MGEOVar(tau=1.0, n_walkers=5, bits=8),
}


def study(seeds, folder=None):
    """The comparison at 10,000 evaluations."""
    problem = SensorSuiteProblem(threads=1)
    return mgeo.compare(problem, ALGORITHMS, 10_000, seeds, folder=folder, n_jobs=2, grid=10)


if __name__ == "__main__":
    seeds = int(sys.argv[1]) if len(sys.argv) > 1 else 20
    found = study(seeds, sys.argv[2] if len(sys.argv) > 2 else None)
    print(found)
    for indicator in found.indicators:
        print(indicator.name, found.order(indicator.name))
        print(found.tests(indicator.name).pairs.to_string(index=False))
