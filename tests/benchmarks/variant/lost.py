"""Where on the front hypervolume is lost: by ranges of t_end, against the union of all runs.

    python -m tests.benchmarks.variant.lost

The paper's preset with a step of 4 s, a quarter of the work: its values are its own.
"""

from __future__ import annotations

import dataclasses
from itertools import pairwise

import numpy as np
from mgeo_attitude import AttitudeManeuverProblem, Scenario

from mgeo.dominance import nondominated

from .record import runs
from .spaces import Floats, Watched
from .tables import FOLDER, OURS, fill, markdown

EDGES = (0, 1200, 2000, 4000, 8000, 11984)  # of t_end [s]
EVALUATIONS = 20_000
SEEDS = [1, 2, 3]
ALGORITHMS = (OURS, "nsga2", "age-moea2", "gde3", "mgeo-real:sigma=1.0,perturbation='range'")


def attained(problem: AttitudeManeuverProblem, F: Floats) -> Floats:
    """Height of the dominated area over each second of t_end, in the indicator space."""
    points = problem.indicator_space(F[nondominated(F)])
    points = points[points[:, 0].argsort()]
    seconds = int(problem.scenario.duration)
    last = np.searchsorted(points[:, 0], (np.arange(seconds) + 0.5) / seconds, side="right") - 1
    heights: Floats = np.where(last >= 0, 1.0 - np.minimum(points[last, 1], 1.0), 0.0) / seconds
    return heights


def main() -> None:
    scenario = dataclasses.replace(Scenario.paper(), step=4.0)
    problem = AttitudeManeuverProblem(scenario, threads=1)
    traces = {name: list(runs(name, Watched(problem), SEEDS, EVALUATIONS)) for name in ALGORITHMS}
    best = attained(problem, np.concatenate([F for each in traces.values() for F in each]))
    rows = [
        ["algorithm", "seed", "least t_end [s]", *(f"to {edge:,} s" for edge in EDGES[1:]), "sum"]
    ]
    for name, each in traces.items():
        for seed, F in zip(SEEDS, each, strict=True):
            lost = best - attained(problem, F)
            parts = [lost[a:b].sum() for a, b in pairwise(EDGES)]
            cells = [f"{value:.4f}" for value in (*parts, lost.sum())]
            rows.append([name, str(seed), f"{F[:, 0].min():.0f}", *cells])
    path = FOLDER / "README.md"
    text = fill(path.read_text(encoding="utf-8"), {"lost": markdown(rows)})
    path.write_text(text, encoding="utf-8")
    print(markdown(rows))


if __name__ == "__main__":
    main()
