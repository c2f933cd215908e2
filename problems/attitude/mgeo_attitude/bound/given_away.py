"""What the limit of a scenario does not ask for, by name."""

from __future__ import annotations

import numpy as np

from mgeo_attitude.bound.samples import Samples
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.scenario import Scenario


def given_away(scenario: Scenario, model: FilterModel, told: Samples) -> tuple[str, ...]:
    """Each in one line, beside that each 3-vector counts as if all else were known."""
    found = [f"{name}: noise counts as nowhere more than on its best axis" for name in told.uneven]
    for sensor in model.suite.sensors:
        if sensor.views():
            found.append(f"{sensor.name}: sees whatever the attitude")
        if sensor.max_rate() < np.inf:
            found.append(f"{sensor.name}: measures at any rate")
    if (model.initial_correlation != np.eye(len(model.initial_sigma))).any():
        found.append("correlations at the start: of each 3-vector what is not known by the others")
    if model.suite.considered.size:
        found.append("considered errors count as known, but for themselves")
    if len(model.suite.gyro.states()) > 1:
        found.append("gyro errors that turn with the rate: any attitude, at the greatest rates")
    turning = [
        ("ramps", model.slew_limits),
        ("path limits", model.path_limits),
        ("wheels", scenario.wheels),
    ]
    found += [f"{name}: the attitude is free" for name, there in turning if there]
    return tuple(found)
