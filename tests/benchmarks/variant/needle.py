"""How early constant spins converge: what the early end of the front looks like.

python -m tests.benchmarks.variant.needle [--spins 20000] [--seed 5]
"""

from __future__ import annotations

import argparse

import numpy as np
from mgeo_attitude import AttitudeManeuverProblem
from numpy.typing import NDArray

from .spaces import problem_by_name

Floats = NDArray[np.float64]

EARLY = 850.0  # s; runs that find nothing better end between 870 and 950
AROUND, WIDTH = 2_000, 0.05  # neighbors of the earliest spins, and their distance [deg/s]


def convergence(problem: AttitudeManeuverProblem, spins: Floats) -> Floats:
    """t_end [s] of spins, shape (n, 3) [deg/s], held from the start to the end."""
    designs = np.zeros((len(spins), problem.n_var))
    designs[:, -4:-1] = spins
    found: Floats = problem.evaluate(designs, return_values_of=["F"])[:, 0]
    return found


def told(t_end: Floats) -> str:
    """Share of the early ones, the first and the median."""
    early = (t_end < EARLY).mean()
    return (
        f"{100 * early:.2f}% before {EARLY:g} s, first {t_end.min():g} s, "
        f"median {np.median(t_end):g} s"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--spins", type=int, default=20_000)
    parser.add_argument("--seed", type=int, default=5)
    given = parser.parse_args()
    problem, rng = problem_by_name("attitude"), np.random.default_rng(given.seed)
    limit = problem.scenario.maneuvers.max_rate_deg_s
    spins = rng.uniform(-limit, limit, (given.spins, 3))
    t_end = convergence(problem, spins)
    print(f"{given.spins} spins: {told(t_end)}")
    for i in np.argsort(t_end)[:4]:
        near = spins[i] + rng.normal(0.0, WIDTH, (AROUND, 3))
        found = convergence(problem, np.clip(near, -limit, limit))
        print(f"around {np.round(spins[i], 3).tolist()} deg/s, {t_end[i]:g} s: {told(found)}")


if __name__ == "__main__":
    main()
