"""Whatever attitude and rate a flight starts with, and whoever flies it."""

import pytest
from mgeo_attitude import Scenario
from mgeo_calibration import calibrate, fly

from .flights import PLAN, check_claimed, normalized

STARTS = {
    "GCRS": {},
    "turned": {"quaternion": [0.5, -0.1, 0.7, 0.5], "rate_deg_s": [0.4, -0.7, 0.3]},
    "nadir": {"pointing": "nadir"},
    "Sun": {"pointing": "sun", "axis": [1.0, 0.0, 0.0]},
}


def starting(start, preset="cubesat_6u"):
    """A preset that starts so; with `nadir` at the orbital rate."""
    return Scenario.from_dict(
        {"preset": preset, "duration": 1500.0, "initial": {"attitude_deg": 10.0, **STARTS[start]}}
    )


@pytest.mark.cases(2)
@pytest.mark.parametrize("start", STARTS)
@pytest.mark.parametrize("preset", ["paper", "cubesat_6u"])
def test_every_start_is_found(start, preset):
    scenario = starting(start, preset)
    telemetry = fly(scenario, PLAN, 11)
    check_claimed([normalized(calibrate(scenario, telemetry), telemetry)], 0.998)
