"""Agreement of the compiled filter with filterpy on random designs.

The environment variable `MGEO_DESIGNS` is the number of designs of the paper's scenario. Each suite
has a fifth of the number.
"""

import dataclasses
import os

import numpy as np
import pytest
from mgeo_attitude import FilterModel

from .agreement import assert_agrees, designs
from .suites import CHANNELS, SUITES

COUNT = int(os.environ.get("MGEO_DESIGNS", "25"))


@pytest.mark.slow
def test_filters_agree_on_random_designs(paper):
    assert_agrees(paper, designs(np.random.default_rng(2), COUNT))


@pytest.mark.slow
@pytest.mark.parametrize("name", SUITES)
def test_filters_agree_for_each_suite(name, short):
    suite = SUITES[name]
    scenario = dataclasses.replace(
        short,
        gyro=suite.gyro,
        sensors=suite.sensors,
        environment_errors=suite.environment_errors,
        housekeeping_channels=CHANNELS,
    )
    X = designs(np.random.default_rng(3), COUNT // 5, max_duration=300.0)
    assert_agrees(FilterModel.from_scenario(scenario), X)
