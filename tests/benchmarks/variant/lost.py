"""Where on the front hypervolume is lost: by ranges of t_end, against the union of all runs.

    python -m tests.benchmarks.variant.lost

Mean over seeds on the coarse problem, whose values are its own.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from mgeo_attitude import AttitudeManeuverProblem

from mgeo.pareto.dominance import nondominated

from .record import runs
from .spaces import Floats, Watched, problem_by_name
from .tables import FOLDER, OURS, fill, markdown

EDGES = (0, 1200, 2000, 4000, 8000, 11984)  # of t_end [s]
EVALUATIONS = 60_000
SEEDS = list(range(1, 9))
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
    problem = problem_by_name("attitude-coarse")
    traces = {name: list(runs(name, Watched(problem), SEEDS, EVALUATIONS)) for name in ALGORITHMS}
    best = attained(problem, np.concatenate([F for each in traces.values() for F in each]))
    edges = [f"to {edge:,} s" for edge in EDGES[1:]]
    rows = [["algorithm", "least t_end [s], median", *edges, "sum"]]
    for name, each in traces.items():
        lost = [best - attained(problem, F) for F in each]
        mean = np.mean([[part[a:b].sum() for a, b in pairwise(EDGES)] for part in lost], axis=0)
        least = np.median([F[:, 0].min() for F in each])
        rows.append([name, f"{least:.0f}", *(f"{value:.4f}" for value in (*mean, mean.sum()))])
    path = FOLDER / "README.md"
    text = fill(path.read_text(encoding="utf-8"), {"lost": markdown(rows)})
    path.write_text(text, encoding="utf-8")
    print(markdown(rows))


if __name__ == "__main__":
    main()
