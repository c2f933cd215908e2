"""A small catalog and a short scenario: their kernel is compiled in seconds."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude.scenario import Convergence
from mgeo_suite import Catalog, SensorSuiteProblem

from mgeo.algorithms import RealEncoding, Variables
from mgeo.algorithms.variables import KINDS

from ..three import three

COSTS = {"price_keur": 1.0, "mass_g": 10.0, "power_mw": 100.0, "source": "made up"}


def grade(name, factor=1.0, **instrument):
    costs = {key: factor * v if isinstance(v, float) else v for key, v in COSTS.items()}
    return {"name": name, **costs, **instrument}


@pytest.fixture(scope="session")
def table():
    return {
        "faces": ["+x", "-z"],
        "gyros": [
            grade("poor", 1.0, angle_random_walk_deg_per_sqrt_h=0.3),
            grade("good", 3.0, bias_decay=1e-4, initial_bias_deg_s=0.002),
        ],
        "magnetometers": [grade("mag", 0.5), grade("better", 2.0, noise_nt=50.0)],
        "sun_sensors": [
            grade("coarse", 0.25, half_angle_deg=80.0),
            grade("fine", 4.0, half_angle_deg=60.0, noise_deg=0.1),
        ],
        "star_trackers": [grade("tracker", 8.0)],
    }


@pytest.fixture(scope="session")
def scenario():
    return dataclasses.replace(
        three("cubesat_6u"),
        name="short",
        duration=1200.0,
        step=10.0,
        convergence=Convergence(window=60.0, relative_decrease=0.05),
    )


@pytest.fixture(scope="session")
def problem(scenario, table):
    objectives = "price", "mass", "power", "attitude", "t_end", "trace"
    return SensorSuiteProblem(scenario, Catalog.from_dict(table), objectives)


@pytest.fixture
def points(problem):
    """(40, n_var) numbers of designs whose maneuvers are over early."""
    code = RealEncoding(Variables.from_problem(problem, KINDS))
    rng = np.random.default_rng(1)
    X = code.draw([rng] * 40)
    X[:, len(problem.suites.places) + 3 :: 4] *= 0.15
    return X
