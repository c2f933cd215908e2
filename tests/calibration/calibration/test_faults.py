"""Faults are identified with their size, down to sizes that matter."""

import dataclasses
import re

import numpy as np
import pytest
from mgeo_calibration import TelemetryMapping, calibrate
from mgeo_calibration.calibration.diagnosis import list_data_faults, run_checks
from mgeo_calibration.estimation.batch import build_batch
from mgeo_calibration.telemetry.mapping import GyroChannels

from .faults import MOTION, SCENARIO, names_cause
from .independent_simulator import TrueErrors, coning_motion, simulate_readings, tumbling_motion
from .runs import short


@pytest.mark.parametrize("late", [-0.2, 0.2])
def test_sensor_latency_is_identified_with_size(late):
    """Without the test, the calibration was consistent with a Sun sensor misalignment wrong by 6
    sigma.
    """
    found = calibrate(
        SCENARIO, simulate_readings(SCENARIO, MOTION, 5, TrueErrors(late={"mag": late}))
    )
    assert not found.is_consistent
    verb, first = "lag" if late > 0.0 else "precede", found.failures[0]
    said = re.match(rf"mag readings {verb} their times by ([0-9.]+) ± ([0-9.]+) s", first.cause)
    assert "mag.initial_latency_s" in first.action
    size, sigma = map(float, said.groups())
    assert sigma < 0.03
    assert abs(size - abs(late)) < 3.0 * sigma


def test_instantaneous_rates_are_identified():
    """Without the test, magnetometer and Sun sensor seemed late by half a step. The reported key
    corrects the calibration.
    """
    scenario = short(SCENARIO, 600.0)
    telemetry = simulate_readings(
        scenario, coning_motion(1.0, 0.1), 3, TrueErrors(instantaneous=True), duration=600.0
    )
    found = calibrate(scenario, telemetry)
    first = found.failures[0]
    said = re.match(r"gyro rates precede their times by ([0-9.]+) ± ([0-9.]+) s", first.cause)
    assert 'rate = "instantaneous" under [gyro]' in first.action
    size, sigma = map(float, said.groups())
    assert sigma < 0.1
    assert abs(size - 0.5) < 3.0 * sigma
    mapping = TelemetryMapping(gyro=GyroChannels(rate="instantaneous"))
    assert calibrate(scenario, telemetry.to_frame(), mapping).is_consistent


def test_instantaneous_rates_of_spinning_body_give_note():
    """Half a step is a rotation about the spin axis: misalignments were wrong by 14 sigma without a
    message.
    """
    scenario = short(SCENARIO, 600.0)
    spin = tumbling_motion((0.185, 0.144, 0.061), (0.28, 0.0, 1.45), 600.0)
    for instantaneous in (True, False):
        craft = TrueErrors(instantaneous=instantaneous)
        found = calibrate(scenario, simulate_readings(scenario, spin, 1, craft, duration=600.0))
        assert found.is_consistent
        told = [note for note in found.notes if note.startswith("gyro rates precede ")]
        assert len(told) == instantaneous
        if told:
            assert "misalignment changes by" in told[0]


@pytest.mark.slow
def test_indistinguishable_errors_are_both_reported():
    """The drift differs from the temperature profile only by what no reading observes."""
    telemetry = simulate_readings(SCENARIO, MOTION, 9)
    share = telemetry.times / 3000.0
    frame = telemetry.to_frame()
    frame["temperature"] = 20.0 + 5.0 * share + 0.05 * np.sin(0.05 * telemetry.times)
    frame["mag_x"] += 200.0 * share
    (failure,) = calibrate(SCENARIO, frame).failures
    line = str(failure)
    assert names_cause(r"mag\.bias changes by [^;]*, at a constant rate", line)
    assert names_cause(r"mag\.bias depends on temperature by ", line)
    assert not names_cause(r"sun\.", line)


def test_overestimated_noise_gives_note():
    """The calibration is consistent, with 1-sigmas that are too large."""
    sun, mag = SCENARIO.sensors
    careful = dataclasses.replace(
        SCENARIO, sensors=(dataclasses.replace(sun, noise_deg=1.4 * sun.noise_deg), mag)
    )
    found = calibrate(careful, simulate_readings(SCENARIO, MOTION, 1))
    assert found.is_consistent
    (note,) = (note for note in found.notes if note.startswith("sun"))
    said = re.search(r"larger than the measured noise of ([0-9.]+) deg", note)
    assert float(said[1]) == pytest.approx(sun.noise_deg, rel=0.03)


def test_healthy_telemetry_has_no_fault():
    for seed in (1, 2):
        telemetry = simulate_readings(SCENARIO, MOTION, seed)
        assert (
            list_data_faults(run_checks(SCENARIO, telemetry, build_batch(SCENARIO, telemetry)))
            == ()
        )


@pytest.mark.slow
def test_bias_sensitivity_is_identified_with_size():
    """The magnetometer bias changes by 12 nT per degree; other channels are uncorrelated."""
    telemetry = simulate_readings(SCENARIO, MOTION, 6)
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
        r"mag\.bias depends on temperature by ([0-9.]+) ± ([0-9.]+) nT per unit along y",
        found.failures[0].cause,
    )
    size, sigma = map(float, said.groups())
    assert abs(size - 12.0) < 4.0 * sigma + 0.5
    assert sigma < 1.0
