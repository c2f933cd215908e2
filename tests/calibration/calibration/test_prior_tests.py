"""Estimates that contradict their prior."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import Scenario
from mgeo_calibration import calibrate
from mgeo_calibration.calibration.consistency_tests import ALL_STATES

from .independent_simulator import TrueErrors, constant_rates, simulate_readings
from .runs import PLAN, short

SCENARIO = short(Scenario.cubesat_6u(), 1500.0)

#: Errors that are far from their prior, and their distance in 1-sigmas.
OFF = {
    "mag.bias": ({"mag_bias_nt": [5000.0, 0.0, 0.0]}, 10.0),
    "sun.misalignment": ({"sun_turn_deg": [0.0, 0.0, 90.0]}, 229.0),
}


def calibrate_with_errors(seed=1, **craft):
    return calibrate(
        SCENARIO,
        simulate_readings(
            SCENARIO, constant_rates(PLAN), seed, TrueErrors(**craft), duration=1500.0
        ),
    )


@pytest.mark.slow
@pytest.mark.parametrize("block", OFF)
def test_block_far_from_prior_is_identified(block):
    """Without the test, the innovations were consistent, or another sensor was reported."""
    craft, sigmas = OFF[block]
    found = calibrate_with_errors(**craft)
    assert not found.is_consistent
    assert found.failures[len(found.data_faults)].cause.startswith(
        f"{block} differs from its prior"
    )
    assert found.data_faults == ()
    assert 'the test "prior" failed' in found.conclusion
    row = found.build_prior_test_table().loc[block]
    assert row["max_deviation_sigmas"] == pytest.approx(sigmas, rel=0.1)
    assert row["chi_square"] >= row["max_deviation_sigmas"] ** 2 * (1.0 - 1e-9)
    assert row["p"] < 1e-6
    assert found.build_prior_test_table().loc[ALL_STATES, "p"] < 1e-6
    named = [failure for failure in found.failures if failure.test == "prior"]
    assert len(named) < len(OFF)


@pytest.mark.slow
def test_second_calibration_is_tested_against_first():
    """For the same satellite it agrees; with another magnetometer bias it does not."""
    first = SCENARIO
    telemetry = simulate_readings(first, constant_rates(PLAN), 3, duration=1500.0)
    half = calibrate(first, telemetry.truncate(800.0))
    after = half.build_followup_scenario({"duration": 700.0})
    rest = dataclasses.replace(telemetry, times=telemetry.times - half.time, truth=None)
    again = calibrate(after, rest)
    assert "attitude" in again.build_prior_test_table().index
    assert again.is_consistent, again.conclusion
    moved = {**rest.sensors, "mag": rest.sensors["mag"] + np.array([0.0, 60.0, 0.0])}
    other = calibrate(after, dataclasses.replace(rest, sensors=moved))
    assert other.failures[0].cause.startswith("mag.bias differs from its prior")


@pytest.mark.slow
def test_inconsistent_calibration_is_no_prior_unless_accepted():
    """Both in Python and from a file."""
    found = calibrate_with_errors(mag_bias_nt=[5000.0, 0.0, 0.0])
    with pytest.raises(ValueError, match=r"after\.conclusion = .*mag\.bias .*accept_inconsistent"):
        found.build_followup_scenario({"duration": 700.0})
    after = found.build_followup_scenario({"duration": 700.0, "accept_inconsistent": True})
    assert after.prior is not None
    with pytest.raises(ValueError, match="accept_inconsistent = 1: expected true or false"):
        found.build_followup_scenario({"accept_inconsistent": 1})
