"""Fixtures: the paper's problem, random designs and their objectives."""

import numpy as np
import pytest
from mgeo_attitude import AttitudeManeuverProblem


@pytest.fixture(scope="session")
def problem():
    return AttitudeManeuverProblem()


@pytest.fixture(scope="session")
def X(problem):
    """Random designs, shape (100, 12), read-only."""
    designs = np.random.default_rng(3).uniform(problem.xl, problem.xu, (100, problem.n_var))
    designs.flags.writeable = False
    return designs


@pytest.fixture(scope="session")
def F(problem, X):
    return problem.evaluate(X)
