"""Random plans are above the lower bound at all times."""

import numpy as np
import pytest
from mgeo_attitude import FilterModel
from mgeo_attitude.lower_bound.assembly import compute_lower_bound

from .plans import (
    build_hard_scenarios,
    compute_least_ratios,
    iterate_random_plans,
    load_documented_scenarios,
    remove_albedo,
)

#: Relative rounding error of some thousand filter steps.
ROUNDING = 1e-9
ALL = load_documented_scenarios() | build_hard_scenarios()
#: With albedo, the measurement of a photodiode depends on the attitude, and no lower bound is
#: known.
ALL["photodiodes.toml"] = remove_albedo(ALL["photodiodes.toml"])


#: Scenarios whose kernel other tests also use. The tests of the others are slow.
FAST = ("paper", "cubesat_6u")


@pytest.mark.parametrize(
    "name", [n if n in FAST else pytest.param(n, marks=pytest.mark.slow) for n in ALL]
)
def test_random_plans_are_above_lower_bound(name):
    scenario = ALL[name]
    model = FilterModel.from_scenario(scenario)
    bound = compute_lower_bound(scenario, model)
    for plans in iterate_random_plans(scenario, np.random.default_rng(1), 48):
        for quantity, ratio in compute_least_ratios(model, bound, plans).items():
            assert ratio >= 1.0 - ROUNDING, quantity
