"""What coils add to a design: rates that are integrated, and a turn of its own in every step."""

import dataclasses
import time

import numpy as np
import pytest
from mgeo_attitude import AttitudeManeuverProblem, FilterModel, Scenario, evaluate

from .measure import interleaved

pytestmark = pytest.mark.benchmark(timer=time.process_time)

#: Docs say ten times; a machine with narrower registers has a slower filter.
MOST = 20.0


def test_a_design_with_coils_against_the_same_of_free_rates():
    """The same satellite, designs and steps in one run, so that the ratio holds on any machine."""
    coils = dataclasses.replace(Scenario.cubesat_1u(), duration=3000.0)
    models = {
        "magnetorquers": FilterModel.from_scenario(coils).full_duration_model,
        "free": FilterModel.from_scenario(
            dataclasses.replace(coils, magnetorquers=None)
        ).full_duration_model,
    }
    problem = AttitudeManeuverProblem(coils)
    X = np.random.default_rng(1).uniform(problem.xl, problem.xu, (24, problem.n_var))
    tasks = {name: lambda model=model: evaluate(model, X, 1) for name, model in models.items()}
    found = interleaved(tasks, rounds=5)
    cost = {name: 1e9 * timing.processor / (24 * 3000) for name, timing in found.items()}
    print(", ".join(f"{name}: {each:.0f} ns a step" for name, each in cost.items()))
    assert 1.0 < cost["magnetorquers"] / cost["free"] < MOST
