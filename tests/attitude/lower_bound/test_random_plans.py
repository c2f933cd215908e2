"""No plan is below the limit, at any time, by any measure."""

import numpy as np
import pytest
from mgeo_attitude import FilterModel
from mgeo_attitude.lower_bound.assembly import compute_lower_bound

from .plans import documented, hard, least_ratios, random_plans, without_albedo

#: What rounding of some thousand filter steps leaves.
ROUNDING = 1e-9
ALL = documented() | hard()
#: Light from the Earth makes a photodiode's reading depend on the attitude in a way that no bound
#: is proved for; without it there is one.
ALL["photodiodes.toml"] = without_albedo(ALL["photodiodes.toml"])


#: Each other has a kernel of its own to compile.
FAST = ("paper", "cubesat_6u")


@pytest.mark.parametrize(
    "name", [n if n in FAST else pytest.param(n, marks=pytest.mark.slow) for n in ALL]
)
def test_no_random_plan_is_below(name):
    scenario = ALL[name]
    model = FilterModel.from_scenario(scenario)
    found = compute_lower_bound(scenario, model)
    for plans in random_plans(scenario, np.random.default_rng(1), 48):
        for what, ratio in least_ratios(model, found, plans).items():
            assert ratio >= 1.0 - ROUNDING, what
