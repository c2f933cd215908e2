"""A truth other than the estimator believes in."""

from __future__ import annotations

from mgeo_attitude.environment import Environment
from mgeo_attitude.fields import declared, require_same
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.filter.suite import Suite
from mgeo_attitude.scenario import Scenario
from mgeo_attitude.flight.readings import n_vectors

#: Keys of a scenario in which a truth may differ.
FREE = ("epoch", "eclipse", "orbit", "gyro", "sensors", "initial")
#: Keys that say nothing of a flight.
_LABELS = ("name", "objectives")


def other_truth(truth: Scenario, scenario: Scenario, environment: Environment) -> FilterModel:
    """Tables of a truth for an estimator that believes in a scenario.

    Parameters
    ----------
    environment : Environment
        Of `scenario`.

    Raises
    ------
    ValueError
        Naming a key in which they may not differ and both values, or other sensors or states.
    """
    shared = [key for key in declared(Scenario) if key not in (*FREE, *_LABELS)]
    require_same("truth", truth, scenario, shared)
    real, believed = (Suite(one.gyro, one.sensors) for one in (truth, scenario))
    for what, found, expected in (
        ("sensors", *([sensor.name for sensor in suite.sensors] for suite in (real, believed))),
        ("states", real.blocks, believed.blocks),
        ("rotations, by number of their first states,", real.rotations, believed.rotations),
        ("readings", *([*map(n_vectors, suite.sensors)] for suite in (real, believed))),
    ):
        if found != expected:
            raise ValueError(f"truth has the {what} {found}: expected the scenario's {expected}")
    if (truth.epoch, truth.orbit) != (scenario.epoch, scenario.orbit):
        environment = Environment.from_scenario(truth)
    return FilterModel.from_scenario(truth, environment)
