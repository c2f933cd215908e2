"""Small catalog and short scenario, whose filter kernels are compiled within seconds."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude.scenario import Convergence
from mgeo_suite import Catalog, SensorSuiteProblem

from mgeo.algorithms import RealEncoding, Variables
from mgeo.algorithms.variables import KINDS

from ..three import three

COSTS = {"price_keur": 1.0, "mass_g": 10.0, "power_mw": 100.0, "source": "invented"}


def build_grade(name, factor=1.0, **instrument):
    costs = {key: factor * v if isinstance(v, float) else v for key, v in COSTS.items()}
    return {"name": name, **costs, **instrument}


@pytest.fixture(scope="session")
def table():
    """Return the table of a small catalog."""
    return {
        "faces": ["+x", "-z"],
        "gyros": [
            build_grade("poor", 1.0, angle_random_walk_deg_per_sqrt_h=0.3),
            build_grade("good", 3.0, bias_decay=1e-4, initial_bias_deg_s=0.002),
        ],
        "magnetometers": [build_grade("mag", 0.5), build_grade("better", 2.0, noise_nt=50.0)],
        "sun_sensors": [
            build_grade("coarse", 0.25, half_angle_deg=80.0),
            build_grade("fine", 4.0, half_angle_deg=60.0, noise_deg=0.1),
        ],
        "star_trackers": [build_grade("tracker", 8.0)],
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
    """Designs as numbers, shape (40, n_var), whose maneuvers end early."""
    encoding = RealEncoding(Variables.from_problem(problem, KINDS))
    rng = np.random.default_rng(1)
    X = encoding.draw([rng] * 40)
    X[:, len(problem.suites.places) + 3 :: 4] *= 0.15
    return X
