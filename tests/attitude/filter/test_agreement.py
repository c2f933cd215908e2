"""The kernel against filterpy on 500 random designs, of the paper's case and of every suite."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import FilterModel, Scenario
from mgeo_attitude.scenario import Convergence

from .agreement import assert_agrees, designs
from .suites import SUITES


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


@pytest.mark.slow
def test_random_designs_agree(paper):
    assert_agrees(paper, designs(np.random.default_rng(2), 500))


@pytest.mark.slow
@pytest.mark.parametrize("name", SUITES)
def test_every_suite_agrees(name, short):
    suite = SUITES[name]
    scenario = dataclasses.replace(short, gyro=suite.gyro, sensors=suite.sensors)
    X = designs(np.random.default_rng(3), 500, max_duration=300.0)
    assert_agrees(FilterModel.from_scenario(scenario), X)
