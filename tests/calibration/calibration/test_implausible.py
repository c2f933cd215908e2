"""Readings and rates that cannot be."""

import numpy as np
import pytest
from mgeo_attitude import Scenario
from mgeo_calibration import calibrate

from .flights import PLAN, normalized, short
from .independent import Craft, coning, fly, steady

SCENARIO = short(Scenario.cubesat_6u(), 1500.0)
MOTIONS = {"plan": steady(PLAN), "turning": coning(3.0, 0.5)}


def right(telemetry):
    found = calibrate(SCENARIO, telemetry)
    nees, x = normalized(found, telemetry)
    assert found.is_consistent, found.conclusion
    assert nees < 34.8 / 18.0  # chi-square of 18, 1 %
    assert np.abs(x).max() < 4.0
    return found


@pytest.mark.parametrize(("name", "value"), [("sun", 1e9), ("mag", -9999.0)])
def test_absurd_readings_are_outliers_and_spoil_nothing(name, value):
    """One in place of a reading was enough for an estimate that does not settle."""
    samples = range(100, 1500, 97)  # in sunlight
    craft = Craft(spikes={(name, k): value for k in samples})
    telemetry = fly(SCENARIO, MOTIONS["plan"], 1, craft, duration=1500.0)
    table = right(telemetry).build_outlier_table()
    listed = table.loc[table["sensor"] == name, "time"]
    assert set(telemetry.times[list(samples)]) <= set(listed)


@pytest.mark.cases(1)
@pytest.mark.parametrize(
    ("motion", "value"),
    [("plan", (1.6, 0.2, 0.1)), ("turning", (30.0, 0.2, 0.1)), ("turning", 1e9)],
)
def test_a_wild_rate_is_told_and_spoils_nothing(motion, value):
    """A spike of 30 deg/s ended 130 sigma off, and the Sun sensor was blamed."""
    craft = Craft(spikes={("gyro", k): np.array(value) for k in range(50, 1450, 300)})
    telemetry = fly(SCENARIO, MOTIONS[motion], 1, craft, duration=1500.0)
    (note,) = right(telemetry).notes
    assert note.startswith("gyro: 5 of 1500 samples differ from both neighbors, by ")


def test_a_turn_within_one_sample_is_kept():
    """It looks like a fault; the vectors say that it is none."""
    kick = np.radians([0.0, 20.0, 0.0])
    plan = MOTIONS["plan"]

    def kicked(t):
        return plan(t) + np.where((t > 700.0) & (t < 701.0), 1.0, 0.0)[..., None] * kick

    found = right(fly(SCENARIO, kicked, 1, duration=1500.0))
    assert found.notes[0].startswith("gyro: 1 of 1500 samples differ")
