"""What is wrong is named, with its size; 60 faults at the edge of mattering."""

import dataclasses
import re

import numpy as np
import pytest
from mgeo_calibration import TelemetryMapping, calibrate
from mgeo_calibration.calibration.diagnosis import list_data_faults, run_checks
from mgeo_calibration.estimation.batch import build_batch
from mgeo_calibration.telemetry.mapping import GyroChannels

from .faults import MOTION, SCENARIO, says
from .flights import short
from .independent import Craft, coning, fly, tumble


@pytest.mark.parametrize("late", [-0.2, 0.2])
def test_a_delay_that_passed_is_told_with_its_size(late):
    """It was supported, with the Sun sensor's misalignment 6 sigma off."""
    found = calibrate(SCENARIO, fly(SCENARIO, MOTION, 5, Craft(late={"mag": late})))
    assert not found.is_consistent
    side = "late" if late > 0.0 else "early"
    said = re.match(
        rf"mag is ([0-9.]+) ± ([0-9.]+) s {side} \(.*: mag\.initial_latency_s$", found.failures[0]
    )
    size, sigma = map(float, said.groups())
    assert sigma < 0.03
    assert abs(size - abs(late)) < 3.0 * sigma


def test_rates_at_the_samples_that_are_read_as_means_are_told():
    """Magnetometer and Sun sensor were blamed, late by half a step; the key that is named mends."""
    scenario = short(SCENARIO, 600.0)
    telemetry = fly(scenario, coning(1.0, 0.1), 3, Craft(instantaneous=True), duration=600.0)
    found = calibrate(scenario, telemetry)
    said = re.match(
        r"gyro reports rates ([0-9.]+) ± ([0-9.]+) s early \(.*: rate = \"instantaneous\" under",
        found.failures[0],
    )
    size, sigma = map(float, said.groups())
    assert sigma < 0.1
    assert abs(size - 0.5) < 3.0 * sigma
    mapping = TelemetryMapping(gyro=GyroChannels(rate="instantaneous"))
    assert calibrate(scenario, telemetry.to_frame(), mapping).is_consistent


def test_rates_at_the_samples_that_a_spin_hardly_tells_from_means_are_a_note():
    """Half a step is a turn about the spin: misalignments were off by 14 sigma, without a word."""
    scenario = short(SCENARIO, 600.0)
    spin = tumble((0.185, 0.144, 0.061), (0.28, 0.0, 1.45), 600.0)
    for instantaneous in (True, False):
        craft = Craft(instantaneous=instantaneous)
        found = calibrate(scenario, fly(scenario, spin, 1, craft, duration=600.0))
        assert found.is_consistent
        told = [note for note in found.notes if note.startswith("gyro reports rates ")]
        assert len(told) == instantaneous
        if told:
            assert "misalignment would be" in told[0]


@pytest.mark.slow
def test_what_can_hardly_be_told_apart_is_told_as_both():
    """A drift that goes as a temperature does, but for what no reading shows."""
    telemetry = fly(SCENARIO, MOTION, 9)
    share = telemetry.times / 3000.0
    frame = telemetry.to_frame()
    frame["temperature"] = 20.0 + 5.0 * share + 0.05 * np.sin(0.05 * telemetry.times)
    frame["mag_x"] += 200.0 * share
    (first, *_) = found = calibrate(SCENARIO, frame).failures
    assert len(found) == 1
    drift, follows = r"mag\.bias changes by [^;]*, evenly", r"mag\.bias follows temperature by "
    assert says(drift, first)
    assert says(follows, first)
    assert not says(r"sun\.", first)


def test_noise_that_is_set_too_high_is_a_note():
    """It ended "not supported", exit 3, with nothing wrong but modest 1-sigmas."""
    sun, mag = SCENARIO.sensors
    careful = dataclasses.replace(
        SCENARIO, sensors=(dataclasses.replace(sun, noise_deg=1.4 * sun.noise_deg), mag)
    )
    found = calibrate(careful, fly(SCENARIO, MOTION, 1))
    assert found.is_consistent
    (note,) = (note for note in found.notes if note.startswith("sun"))
    said = re.match(r"sun: sigmas are too large by 1\.[34]\d?; measured ([0-9.]+) deg", note)
    assert float(said[1]) == pytest.approx(sun.noise_deg, rel=0.03)


def test_no_cause_is_seen_of_a_healthy_flight():
    for seed in (1, 2):
        telemetry = fly(SCENARIO, MOTION, seed)
        assert (
            list_data_faults(run_checks(SCENARIO, telemetry, build_batch(SCENARIO, telemetry)))
            == ()
        )


@pytest.mark.slow
def test_a_bias_that_follows_a_channel_of_the_table_is_told():
    """A magnetometer's bias of 12 nT per degree, beside channels of which nothing follows."""
    telemetry = fly(SCENARIO, MOTION, 6)
    rng, t = np.random.default_rng(6), telemetry.times
    frame = telemetry.to_frame()
    frame["temperature"] = 20.0 + 8.0 * np.sin(2.0 * np.pi * t / 1700.0 + 1.0)
    for k in range(6):
        frame[f"current_{k}"] = np.cumsum(rng.standard_normal(len(t)))
    frame["mode"] = "nominal"
    assert calibrate(SCENARIO, frame).is_consistent
    frame["mag_y"] += 12.0 * frame["temperature"]
    found = calibrate(SCENARIO, frame)
    said = re.match(
        r"mag\.bias follows temperature by ([0-9.]+) ± ([0-9.]+) nT along y", found.failures[0]
    )
    size, sigma = map(float, said.groups())
    assert abs(size - 12.0) < 4.0 * sigma + 0.5
    assert sigma < 1.0
