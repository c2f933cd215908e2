"""Cases on which the kernel and the reference filter are compared."""

import dataclasses

import pytest
from mgeo_attitude import FilterModel, Scenario
from mgeo_attitude.scenario import Convergence


@pytest.fixture(scope="module")
def paper():
    return FilterModel.from_scenario(Scenario.paper())


@pytest.fixture(scope="module")
def short():
    """A tenth of the paper's run, with a coarser step, for tests of many kinds."""
    return dataclasses.replace(
        Scenario.paper(),
        duration=1200.0,
        step=2.0,
        convergence=Convergence(window=60.0, relative_decrease=0.05),
    )
