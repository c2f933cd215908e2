"""Readings and rates that cannot be."""

import dataclasses
from itertools import product

import numpy as np
import pytest
from mgeo_attitude import Scenario
from mgeo_calibration import calibrate
from mgeo_calibration.estimation.batch import batch
from mgeo_calibration.estimation.mistakes import implausible
from mgeo_calibration.telemetry.gyro_samples import spikes

from .flights import PLAN, normalized, short
from .independent import Craft, coning, fly, steady

SCENARIO = short(Scenario.cubesat_6u(), 1500.0)
MOTIONS = {"plan": steady(PLAN), "turning": coning(3.0, 0.5)}


def right(telemetry):
    found = calibrate(SCENARIO, telemetry)
    nees, x = normalized(found, telemetry)
    assert found.supported, found.conclusion
    assert nees < 34.8 / 18.0  # chi-square of 18, 1 %
    assert np.abs(x).max() < 4.0
    return found


@pytest.mark.parametrize("value", [-9999.0, 1e9])
@pytest.mark.parametrize("name", ["sun", "mag"])
def test_absurd_readings_are_outliers_and_spoil_nothing(name, value):
    """One in place of a reading was enough for an estimate that does not settle."""
    samples = range(100, 1500, 97)  # in sunlight
    craft = Craft(spikes={(name, k): value for k in samples})
    telemetry = fly(SCENARIO, MOTIONS["plan"], 1, craft, duration=1500.0)
    table = right(telemetry).rejected_table()
    listed = table.loc[table["sensor"] == name, "time"]
    assert set(telemetry.times[list(samples)]) <= set(listed)


def test_lengths_that_vary_are_no_faults():
    """Neither of a bias as large as the field, nor of noise."""
    craft = Craft(mag_bias_nt=[-51e3, 17e3, -37e3])
    for telemetry in (fly(SCENARIO, MOTIONS["turning"], 1, each, 1500.0) for each in (craft, None)):
        assert not implausible(batch(SCENARIO, telemetry)).any()


@pytest.mark.cases(2)
@pytest.mark.parametrize(
    ("motion", "value"),
    [("plan", (1.6, 0.2, 0.1)), *product(MOTIONS, [(30.0, 0.2, 0.1), -9999.0, 1e9])],
)
def test_a_wild_rate_is_told_and_spoils_nothing(motion, value):
    """A spike of 30 deg/s ended 130 sigma off, and the Sun sensor was blamed."""
    craft = Craft(spikes={("gyro", k): np.array(value) for k in range(50, 1450, 300)})
    telemetry = fly(SCENARIO, MOTIONS[motion], 1, craft, duration=1500.0)
    (note,) = right(telemetry).notes
    assert note.startswith("gyro: 5 of 1500 samples stand apart from both neighbors, by ")


def test_a_turn_within_one_sample_is_kept():
    """It looks like a fault; the vectors say that it is none."""
    kick = np.radians([0.0, 20.0, 0.0])
    plan = MOTIONS["plan"]

    def kicked(t):
        return plan(t) + np.where((t > 700.0) & (t < 701.0), 1.0, 0.0)[..., None] * kick

    found = right(fly(SCENARIO, kicked, 1, duration=1500.0))
    assert found.notes[0].startswith("gyro: 1 of 1500 samples stand apart")


def test_jumps_and_swings_are_no_spikes():
    rng = np.random.default_rng(1)
    t = np.arange(500.0)
    swing = 3.0 * np.stack([np.cos(0.5 * t), np.sin(0.5 * t), np.cos(1.5 * t)], axis=1)
    jumps = np.where((t > 100.0) & (t < 200.0), 2.0, -1.0)[:, None] * np.ones(3)
    jumps[100] = 0.3  # the change falls within this sample
    noise = rng.normal(0.0, 0.0025, (500, 3))
    for rates in (swing, jumps, swing + noise, jumps + noise, noise):
        assert not spikes(rates, np.full(3, 0.0025)).any()
    wild = noise.copy()
    wild[[250, 300, 301], 1] += 0.5, 0.5, 0.7
    found = spikes(wild, np.full(3, 0.0025))
    assert np.flatnonzero(found.any(axis=1)).tolist() == [250, 300, 301]
    np.testing.assert_allclose(found[[250, 300, 301], 1], [0.5, 0.5, 0.7], atol=0.01)


def test_the_step_of_a_channel_is_seen_beside_an_absurd_number():
    telemetry = fly(SCENARIO, MOTIONS["plan"], 1, Craft(mag_step_nt=300.0), duration=1500.0)
    rows = telemetry.sensors["mag"].copy()
    rows[100] = 1e9
    wrong = dataclasses.replace(telemetry, sensors={**telemetry.sensors, "mag": rows})
    np.testing.assert_allclose(wrong.step_of("mag"), 300.0, rtol=1e-6)
