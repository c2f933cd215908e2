"""Time of designs with magnetorquers, whose rates are integrated, compared with designs of free
rates.
"""

import dataclasses
import time

import numpy as np
import pytest
from mgeo_attitude import AttitudeManeuverProblem, FilterModel, Scenario, evaluate

from .measure import time_interleaved

pytestmark = pytest.mark.benchmark(timer=time.process_time)

#: The documentation states a ratio of ten. Machines with narrower registers have a slower filter.
MAX_RATIO = 20.0


def test_magnetorquer_design_costs_bounded_multiple_of_free_rates():
    """Both models evaluate the same designs in one process, so that the ratio holds on other
    machines.
    """
    with_magnetorquers = dataclasses.replace(Scenario.cubesat_1u(), duration=3000.0)
    models = {
        "magnetorquers": FilterModel.from_scenario(with_magnetorquers).full_duration_model,
        "free": FilterModel.from_scenario(
            dataclasses.replace(with_magnetorquers, magnetorquers=None)
        ).full_duration_model,
    }
    problem = AttitudeManeuverProblem(with_magnetorquers)
    X = np.random.default_rng(1).uniform(problem.xl, problem.xu, (24, problem.n_var))
    tasks = {name: lambda model=model: evaluate(model, X, 1) for name, model in models.items()}
    timings = time_interleaved(tasks, rounds=5)
    cost = {name: 1e9 * timing.processor / (24 * 3000) for name, timing in timings.items()}
    print(", ".join(f"{name}: {each:.0f} ns a step" for name, each in cost.items()))
    assert 1.0 < cost["magnetorquers"] / cost["free"] < MAX_RATIO
