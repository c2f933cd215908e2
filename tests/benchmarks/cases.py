"""What the benchmarks run: suites of growing size, their models and random designs."""

from __future__ import annotations

import dataclasses
from functools import cache
from pathlib import Path

import numpy as np
from mgeo_attitude import FilterModel, Gyro, Magnetometer, Scenario, Suite, SunSensor
from numpy.typing import NDArray

Floats = NDArray[np.float64]

PAPER = "paper"

#: The presets as they were when the experiments and the proof of consistency were recorded.
_SCENARIOS = Path(__file__).parents[2] / "docs" / "scenarios"
FORMER_PAPER = _SCENARIOS / "paper-1-percent.toml"
FORMER_CUBESAT = _SCENARIOS / "cubesat-6u-with-rises.toml"

#: Suites by name, ordered by size. All fields of view are open: the scalar loop has none.
SUITES = {
    "no magnetometer": Suite(Gyro(), (SunSensor(),)),
    PAPER: Suite(Gyro(), (SunSensor(), Magnetometer())),
    "two Sun sensors": Suite(
        Gyro(), (SunSensor(name="sun_1"), SunSensor(name="sun_2"), Magnetometer())
    ),
    "gyro scale factors and misalignments": Suite(
        Gyro(initial_scale_factor=1e-3, initial_misalignment_deg=0.1), (SunSensor(), Magnetometer())
    ),
}


#: A preset with more kinds of states than the scalar loop knows.
FULL = "cubesat_6u_full"


@cache
def model(name: str) -> FilterModel:
    """The paper's scenario with another suite, or the preset `FULL`."""
    if name == FULL:
        return FilterModel.from_scenario(Scenario.cubesat_6u_full())
    suite = SUITES[name]
    scenario = dataclasses.replace(
        Scenario.paper(),
        gyro=suite.gyro,
        sensors=suite.sensors,
        environment_errors=suite.environment_errors,
    )
    return FilterModel.from_scenario(scenario)


def designs(n: int, maneuvers: int = 3) -> Floats:
    """Random designs inside the paper's bounds, shape (n, 4 maneuvers).

    However many maneuvers there are, together they last as long as the paper's three can.
    """
    rng = np.random.default_rng(2024)
    X = rng.uniform(-1.0, 1.0, (n, 4 * maneuvers))
    X[:, 3::4] = rng.uniform(0.0, 6000.0 / maneuvers, (n, maneuvers))
    return X
