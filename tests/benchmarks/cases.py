"""Cases of the benchmarks: sensor suites of increasing size, their filter models, and random
designs.
"""

from __future__ import annotations

import dataclasses
from functools import cache
from pathlib import Path

import numpy as np
from mgeo_attitude import FilterModel, Gyro, Magnetometer, Scenario, Suite, SunSensor
from numpy.typing import NDArray

Floats = NDArray[np.float64]

PAPER = "paper"

#: Former versions of the presets, with which the stored experiments were made.
_SCENARIOS = Path(__file__).parents[2] / "docs" / "scenarios"
FORMER_PAPER = _SCENARIOS / "paper-1-percent.toml"
FORMER_CUBESAT = _SCENARIOS / "cubesat-6u-with-rises.toml"

#: Suites by name, ordered by size. Fields of view are unlimited, as in the loops of `textbook`.
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


#: Preset with more kinds of states than the loops in `textbook` support.
FULL = "cubesat_6u_full"


@cache
def build_model(name: str) -> FilterModel:
    """Return the filter model of the paper's scenario with one of `SUITES`, or of the preset
    `FULL`.
    """
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


def draw_designs(n: int, maneuvers: int = 3) -> Floats:
    """Return random designs within the paper's bounds, shape (n, 4 maneuvers).

    The longest total duration does not depend on the number of maneuvers.
    """
    rng = np.random.default_rng(2024)
    X = rng.uniform(-1.0, 1.0, (n, 4 * maneuvers))
    X[:, 3::4] = rng.uniform(0.0, 6000.0 / maneuvers, (n, maneuvers))
    return X
