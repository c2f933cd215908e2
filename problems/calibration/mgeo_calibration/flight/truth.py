"""A truth other than the estimator believes in."""

from __future__ import annotations

from mgeo_attitude.environment import Environment
from mgeo_attitude.fields import declared, require_same
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.scenario import InitialConditions, Scenario
from mgeo_attitude.sensors.readings import n_vectors

#: Keys of a scenario in which a truth may differ, and those that say nothing of a flight. Of
#: `initial` that is how well the attitude is known: what is flown starts from the believed one.
FREE = ("epoch", "eclipse", "orbit", "gyro", "sensors", "world", "initial", "name", "objectives")


def other_truth(truth: Scenario, scenario: Scenario, environment: Environment) -> FilterModel:
    """Tables of a truth for an estimator that believes in a scenario, of which `environment` is.

    Raises
    ------
    ValueError
        Naming a key in which they may not differ and both values, or other sensors or states.
    """
    require_same("truth", truth, scenario, [key for key in declared(Scenario) if key not in FREE])
    start = [key for key in declared(InitialConditions) if key != "attitude_deg"]
    require_same("truth.initial", truth.initial, scenario.initial, start)
    real, believed = (one.suite for one in (truth, scenario))
    for what, found, expected in (
        ("sensors", *([sensor.name for sensor in suite.sensors] for suite in (real, believed))),
        ("states", real.blocks, believed.blocks),
        ("rotations, by number of their first states,", real.rotations, believed.rotations),
        ("readings", *([*map(n_vectors, suite.sensors)] for suite in (real, believed))),
    ):
        if found != expected:
            raise ValueError(f"truth has the {what} {found}: expected the scenario's {expected}")
    return FilterModel.from_scenario(truth, surroundings(truth, scenario, environment))


def surroundings(truth: Scenario, scenario: Scenario, environment: Environment) -> Environment:
    """The truth's, without the Earth's shadow if it has none, where the scenario's are given."""
    if (truth.epoch, truth.orbit) != (scenario.epoch, scenario.orbit):
        environment = Environment.from_scenario(truth)
    return environment if truth.eclipse else environment.without_shadow()
