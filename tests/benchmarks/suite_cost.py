"""What a filter step costs where designs have different sensors, against the attitude problem.

.venv/bin/python -m tests.benchmarks.suite_cost
"""

from __future__ import annotations

import dataclasses

import numpy as np
from mgeo_attitude import AttitudeManeuverProblem
from mgeo_attitude.scenario import Convergence
from mgeo_suite import SensorSuiteProblem

from mgeo.algorithms.coding import RealCode
from mgeo.algorithms.variables import KINDS, Variables

from .measure import interleaved

_DESIGNS = 192


def costs(rounds: int = 7) -> dict[str, float]:
    """Processor time [ns] of a useful step of each problem, on one thread, all in one run.

    "complete" is the attitude problem with a sensor in every place of the catalog, "sensors
    carried" with those of one suite alone, by a kernel of its own; "one suite", "complete suites"
    and "many suites" are designs of the suite problem: all of that suite, each of another grade in
    every place, each of any suite.
    """
    suites = SensorSuiteProblem(threads=1)
    places = len(suites.suites.places)
    X = RealCode(Variables.of(suites, KINDS)).draw([np.random.default_rng(1)] * _DESIGNS)
    one = X.copy()
    one[:, :places] = (1, 1, 0, 2, 0, 0, 0, 0, 0)  # two vectors, as most satellites have
    gyro, mag, _, head, *_ = (
        place.instruments[n]
        for place, n in zip(suites.suites.places, one[0].astype(int), strict=False)
    )
    every = np.maximum(
        X, np.r_[np.zeros(2), np.ones(places - 2), np.full(X.shape[1] - places, -9e9)]
    )
    # until the end of the run, so that all fly the same number of steps
    rule = Convergence(window=300.0, relative_decrease=1e-12)
    full = dataclasses.replace(suites.scenario, convergence=rule)
    own = dataclasses.replace(full, gyro=gyro, sensors=(mag, head))
    problem = SensorSuiteProblem(full, suites.catalog, threads=1)
    complete, carried = (AttitudeManeuverProblem(each, threads=1) for each in (full, own))
    tasks = {
        "complete": lambda: complete._run(X[:, places:]),
        "sensors carried": lambda: carried._run(X[:, places:]),
        "one suite": lambda: problem._run(one),
        "complete suites": lambda: problem._run(every),
        "many suites": lambda: problem._run(X),
    }
    counts = {
        "complete": complete._run(X[:, places:])[:, 0],
        "sensors carried": carried._run(X[:, places:])[:, 0],
        "one suite": problem.evaluation(one).t_end,
        "complete suites": problem.evaluation(every).t_end,
        "many suites": problem.evaluation(X).t_end,
    }
    timings = interleaved(tasks, rounds)
    return {name: 1e9 * timings[name].processor * full.step / counts[name].sum() for name in tasks}


if __name__ == "__main__":
    for name, cost in costs().items():
        print(f"{name}: {cost:.0f} ns a step")
