"""What a filter step costs where designs have different sensors, against the attitude problem.

.venv/bin/python -m tests.benchmarks.suite_cost
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from mgeo_attitude import AttitudeManeuverProblem
from mgeo_attitude.scenario import Convergence
from mgeo_suite import SensorSuiteProblem
from mgeo_suite.catalog import NONE

from mgeo.algorithms import KINDS, RealCode, Variables

from .measure import interleaved

_DESIGNS = 192
_TRACKER, _FACES = 2, 3  # places


class Cost(NamedTuple):
    """Processor time [ns] of a step of the same plans, flown with a tracker or not and heads.

    Attributes
    ----------
    star_tracker, sun_sensors : int
        How many the satellite carries, beside gyro and magnetometer.
    states : int
    attitude : float
        Of the attitude problem with one suite of these.
    one, many : float
        Of the suite problem with that suite, and with other grades and faces in every design.
    """

    star_tracker: int
    sun_sensors: int
    states: int
    attitude: float
    one: float
    many: float


def costs(rounds: int = 5) -> Iterator[Cost]:
    """Of each number of sensors, on one thread, all three in one run.

    Plans are random, so that no two share a beginning, and fly until the end: all problems do the
    same steps, of the same states.
    """
    default = SensorSuiteProblem()
    rule = Convergence(window=300.0, relative_decrease=1e-12)
    scenario = dataclasses.replace(default.scenario, convergence=rule)
    problem = SensorSuiteProblem(scenario, default.catalog, threads=1)
    places, rng = problem.suites.places, np.random.default_rng(1)
    drawn = RealCode(Variables.of(problem, KINDS)).draw([rng] * _DESIGNS)
    plans, faces = drawn[:, len(places) :], len(places) - _FACES
    for tracker in (0, 1):
        for heads in range(faces + 1):
            one, many = drawn.copy(), drawn.copy()
            one[:, : len(places)] = (1, 1, tracker, *[2] * heads, *[0] * (faces - heads))
            for row in many:
                row[:_TRACKER] = [rng.integers(len(p.options)) for p in places[:_TRACKER]]
                row[_TRACKER] = tracker * rng.integers(1, len(places[_TRACKER].options))
                there = rng.permutation(faces) < heads
                row[_FACES : len(places)] = there * rng.integers(1, len(places[-1].options), faces)
            own = _attitude(problem, one[0])
            tasks = {
                "attitude": lambda own=own: own._run(plans),
                "one": lambda one=one: problem._run(one),
                "many": lambda many=many: problem._run(many),
            }
            ends = own._run(plans)[:, 0]
            for X in (one, many):
                assert np.array_equal(problem.evaluation(X).t_end, ends)
            timings = interleaved(tasks, rounds)
            step = 1e9 * scenario.step / ends.sum()
            values = {name: step * timing.processor for name, timing in timings.items()}
            yield Cost(tracker, heads, own.model.suite.n_states, **values)


def _attitude(problem: SensorSuiteProblem, row: np.ndarray) -> AttitudeManeuverProblem:
    """That of the satellite which carries the suite of a design, and nothing else."""
    places = problem.suites.places
    chosen = [
        place.instruments[n]
        for place, n in zip(places, row[: len(places)].astype(int), strict=True)
        if place.options[n] != NONE
    ]
    scenario = dataclasses.replace(problem.scenario, gyro=chosen[0], sensors=tuple(chosen[1:]))
    return AttitudeManeuverProblem(scenario, threads=1)


if __name__ == "__main__":
    print("star tracker  Sun sensors  states  attitude [ns]  one suite  many suites")
    for cost in costs():
        one, many = cost.one / cost.attitude, cost.many / cost.attitude
        print(
            f"{cost.star_tracker:12}{cost.sun_sensors:13}{cost.states:8}{cost.attitude:15.0f}"
            f"{one:11.2f}{many:13.2f}"
        )
