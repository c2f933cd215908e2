"""Fixtures: the paper's problem, and a design with a run of the reference filter."""

import numpy as np
import pytest
from mgeo_attitude import AttitudeManeuverProblem, run_reference_filter

DESIGN = (0.5, -1.0, 0.25, 200.0, -0.125, 0.75, 1.0, 0.0, 0.0625, -0.5, 0.875, 150.5)


@pytest.fixture(scope="session")
def problem():
    return AttitudeManeuverProblem()


@pytest.fixture(scope="session")
def design():
    return np.array(DESIGN)


@pytest.fixture(scope="session")
def history(problem, design):
    return run_reference_filter(problem.model, design)
