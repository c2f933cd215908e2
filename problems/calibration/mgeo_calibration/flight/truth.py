"""What is true and not believed: another scenario, and a shadow that is elsewhere."""

from __future__ import annotations

import dataclasses

from mgeo_attitude._typing import Floats
from mgeo_attitude.environment import Environment
from mgeo_attitude.fields import declared, require_same
from mgeo_attitude.filter import FilterModel, availability, sampled
from mgeo_attitude.scenario import InitialConditions, Scenario
from mgeo_attitude.sensors import n_vectors

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


def in_true_shadow(model: FilterModel, environment: Environment, varying: Floats) -> FilterModel:
    """A model whose sensors see the Sun where it truly shines, whoever believes what.

    Parameters
    ----------
    environment : Environment
        Of the orbit that is believed; without its shadow, nothing changes.
    varying : array, shape (n + 1, n_dynamic - 3)
        See `Flight.gyro`.
    """
    suite = model.suite
    if not suite.world.has_orbit_error or not environment.shadow:
        return model
    first = 3 * suite.blocks.index("world.orbit_error") - 3
    there = availability(suite, suite.world.displaced(environment, varying[:, first : first + 3]))
    for column, sensor in zip(there.T, suite.sensors, strict=True):
        column &= sampled(sensor, model.step, len(there))
    return dataclasses.replace(model, available=there)
