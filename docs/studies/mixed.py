"""Comparison of algorithms for mixed variables, on a problem whose options change along the front.

    .venv/bin/python docs/studies/mixed.py [SEEDS]

writes the hypervolume of all evaluations of each run to data/mixed.csv, which
docs/studies/results.md shows, and prints mean and standard deviation.
"""

import sys
from pathlib import Path

import numpy as np
import pandas as pd
from pymoo.algorithms.moo.nsga2 import RankAndCrowdingSurvival
from pymoo.core.mixed import MixedVariableGA
from pymoo.core.problem import Problem
from pymoo.core.variable import Binary, Choice, Integer, Real
from pymoo.indicators.hv import HV
from pymoo.optimize import minimize

from mgeo import MGEOCanonical, MGEODirected
from mgeo.evaluation.individuals import convert_designs_to_numbers
from mgeo.runs.algorithms import build_algorithm

AREA = HV(ref_point=np.array([1.1, 1.1]))


class Halves(Problem):
    """Variant of ZDT1 with 9 real variables, 4 integers, 4 choices and 4 binary variables.

    The front is f2 = 1 - sqrt(f1). The optimal integers, options and bits for f1 < 0.5 differ from
    those for larger f1.
    """

    def __init__(self):
        kinds = {f"real {i}": Real(bounds=(0, 1)) for i in range(9)}
        kinds |= {f"integer {i}": Integer(bounds=(0, 20)) for i in range(4)}
        kinds |= {f"choice {i}": Choice(options=list("abcdef")) for i in range(4)}
        kinds |= {f"bit {i}": Binary() for i in range(4)}
        super().__init__(vars=kinds, n_obj=2)

    def _evaluate(self, X, out, *args, **kwargs):
        first, reals, integers, choices, bits = np.split(
            convert_designs_to_numbers(self, np.asarray(X)), [1, 9, 13, 17], axis=1
        )
        low = first < 0.5
        off = [
            np.abs(reals - 0.3),
            np.abs(integers / 20 - np.where(low, 0.25, 0.75)),
            0.5 * (choices != np.where(low, 2, 4)),
            0.5 * (bits != low),
        ]
        g = 1.0 + 9.0 * np.hstack(off).mean(axis=1, keepdims=True)
        out["F"] = np.hstack([first, g * (1.0 - np.sqrt(first / g))])


ALGORITHMS = {
    "MGEODirected": MGEODirected(),
    "MixedVariableGA": MixedVariableGA(pop_size=50, survival=RankAndCrowdingSurvival()),
    "NSGA-II, mixed operators": build_algorithm("nsga2", {"population": 100}, Halves()),
    "MGEOCanonical": MGEOCanonical(bits=8),
}


def volume(algorithm, evaluations, seed):
    """Return the hypervolume of all evaluations of a run."""
    seen, problem = [], Halves()
    minimize(
        problem,
        algorithm,
        ("n_eval", evaluations),
        seed=seed,
        callback=lambda run: seen.append(run.pop.get("F")),
    )
    return AREA(np.concatenate(seen))


if __name__ == "__main__":
    seeds = range(int(sys.argv[1]) if len(sys.argv) > 1 else 10)
    rows = []
    for evaluations in (5_000, 20_000):
        for name, algorithm in ALGORITHMS.items():
            found = [volume(algorithm, evaluations, seed) for seed in seeds]
            print(f"{name}, {evaluations:,}: {np.mean(found):.3f} ± {np.std(found):.3f}")
            rows += [(name, evaluations, *each) for each in zip(seeds, found, strict=True)]
    table = pd.DataFrame(rows, columns=["algorithm", "evaluations", "seed", "hypervolume"])
    target = Path(__file__).parent / "data" / "mixed.csv"
    table.to_csv(target, index=False, float_format="%.6g", lineterminator="\n")
