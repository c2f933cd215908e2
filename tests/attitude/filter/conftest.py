"""Models and scenarios for the tests of the filter."""

import dataclasses

import pytest
from mgeo_attitude import FilterModel, Scenario
from mgeo_attitude.scenario import Convergence


@pytest.fixture(scope="module")
def paper():
    return FilterModel.from_scenario(Scenario.paper())


@pytest.fixture(scope="module")
def short():
    """Scenario with a tenth of the paper's duration and twice its step."""
    return dataclasses.replace(
        Scenario.paper(),
        duration=1200.0,
        step=2.0,
        convergence=Convergence(window=60.0, relative_decrease=0.05),
    )
