"""Implausible readings and rates."""

import numpy as np
import pytest
from mgeo_attitude import Scenario
from mgeo_calibration import calibrate

from .independent_simulator import TrueErrors, coning_motion, constant_rates, simulate_readings
from .runs import PLAN, normalize_error, short

SCENARIO = short(Scenario.cubesat_6u(), 1500.0)
MOTIONS = {"plan": constant_rates(PLAN), "turning": coning_motion(3.0, 0.5)}


def calibrate_consistently(telemetry):
    found = calibrate(SCENARIO, telemetry)
    nees, x = normalize_error(found, telemetry)
    assert found.is_consistent, found.conclusion
    assert nees < 34.8 / 18.0  # Chi-square of 18 degrees of freedom, 1 %.
    assert np.abs(x).max() < 4.0
    return found


@pytest.mark.parametrize(("name", "value"), [("sun", 1e9), ("mag", -9999.0)])
def test_implausible_readings_are_rejected_as_outliers(name, value):
    """A single such reading must not prevent the convergence of the fit."""
    samples = range(100, 1500, 97)  # In sunlight.
    craft = TrueErrors(spikes={(name, k): value for k in samples})
    telemetry = simulate_readings(SCENARIO, MOTIONS["plan"], 1, craft, duration=1500.0)
    table = calibrate_consistently(telemetry).build_outlier_table()
    listed = table.loc[table["sensor"] == name, "time_s"]
    assert set(telemetry.times[list(samples)]) <= set(listed)


@pytest.mark.cases(1)
@pytest.mark.parametrize(
    ("motion", "value"),
    [("plan", (1.6, 0.2, 0.1)), ("turning", (30.0, 0.2, 0.1)), ("turning", 1e9)],
)
def test_gyro_spikes_give_note_and_calibration_is_consistent(motion, value):
    """An unnoticed spike of 30 deg/s leads to an error of 130 sigma."""
    craft = TrueErrors(spikes={("gyro", k): np.array(value) for k in range(50, 1450, 300)})
    telemetry = simulate_readings(SCENARIO, MOTIONS[motion], 1, craft, duration=1500.0)
    (note,) = calibrate_consistently(telemetry).notes
    assert note.startswith("gyro: 5 of 1500 samples differ from both neighbors, by ")


def test_fast_rotation_within_one_sample_is_not_a_spike():
    """The rates resemble a fault; the observed vectors confirm the rotation."""
    kick = np.radians([0.0, 20.0, 0.0])
    plan = MOTIONS["plan"]

    def kicked(t):
        return plan(t) + np.where((t > 700.0) & (t < 701.0), 1.0, 0.0)[..., None] * kick

    found = calibrate_consistently(simulate_readings(SCENARIO, kicked, 1, duration=1500.0))
    assert found.notes[0].startswith("gyro: 1 of 1500 samples differ")
