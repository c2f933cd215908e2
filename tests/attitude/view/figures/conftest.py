"""The paper's problem and designs that converge in both of its orbits."""

import numpy as np
import pytest
from mgeo_attitude import AttitudeManeuverProblem


@pytest.fixture(scope="session")
def problem():
    return AttitudeManeuverProblem()


@pytest.fixture(scope="session")
def X(problem):
    """Shape (100, 12), read-only."""
    designs = np.random.default_rng(3).uniform(problem.xl, problem.xu, (100, problem.n_var))
    designs.flags.writeable = False
    return designs


@pytest.fixture(scope="session")
def F(problem, X):
    return problem.evaluate(X)
