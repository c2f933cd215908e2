"""Quantized channels."""

import dataclasses

import numpy as np
import pandas as pd
import pytest
from mgeo_attitude import Scenario
from mgeo_calibration import calibrate
from mgeo_calibration import simulate_telemetry as fly_plan
from mgeo_calibration.telemetry.mapping import GyroChannels, TelemetryMapping
from mgeo_calibration.telemetry.quantization import (
    compute_angle_variance_rate,
    estimate_quantization_steps,
)
from mgeo_calibration.telemetry.reading import read_telemetry

from .independent_simulator import (
    TrueErrors,
    coning_motion,
    constant_rates,
    quantize,
    simulate_readings,
)
from .runs import PLAN, check_errors, normalize_error, short

SCENARIO = short(Scenario.cubesat_6u(), 3000.0)
MOTIONS = {"plan": constant_rates(PLAN), "turning": coning_motion(1.0, 0.1)}


def test_quantization_step_is_estimated():
    """Numbers with six digits and few or many levels have a step; numbers that hardly repeat have
    none.
    """
    rng = np.random.default_rng(1)
    noise = rng.normal(0.0, 0.03, (3000, 3))
    steps = np.array([0.01, 0.0123, 0.0])
    rows = noise.copy()
    rows[:, :2] = steps[:2] * np.round(noise[:, :2] / steps[:2])
    np.testing.assert_allclose(estimate_quantization_steps(rows), steps, rtol=1e-6)
    np.testing.assert_allclose(estimate_quantization_steps(rows.round(6)), steps, atol=2e-6)
    np.testing.assert_allclose(
        estimate_quantization_steps(rows[:, :1].astype(np.float32)), steps[:1], rtol=1e-5
    )
    filled = np.where(np.arange(3000)[:, None] % 500, rows, 1e250)
    np.testing.assert_allclose(estimate_quantization_steps(filled), steps, rtol=1e-6)
    assert estimate_quantization_steps(noise).tolist() == [0.0] * 3
    assert estimate_quantization_steps(rows[:10]).tolist() == [0.0] * 3
    rests = rows.copy()
    rests[:, 1] = np.where(rng.random(3000) < 0.5, 0.0, 0.7)
    assert estimate_quantization_steps(rests)[1] == pytest.approx(
        0.01
    )  # The step of the finest other channel.
    rests[:, 1] = 0.0
    assert estimate_quantization_steps(rests)[1] == pytest.approx(0.01)


@pytest.mark.parametrize("ratio", [0.1, 0.3, 2.0])
def test_angle_variance_of_quantized_rates_agrees_with_simulation(ratio):
    """Constant rates of ten minutes with random positions between two steps."""
    rng, n, step = np.random.default_rng(2), 600, 0.01
    rate = rng.uniform(-0.5, 0.5, 400) * step
    noise = rng.normal(0.0, ratio * step, (n, 400))
    off = quantize(rate + noise, step) - rate
    said = compute_angle_variance_rate(
        quantize(rate + noise, step)[:, :3], 1.0, np.full(3, step), np.full(3, ratio * step)
    )
    total = said.sum(axis=0).mean() + n * (ratio * step) ** 2
    found = (off.sum(axis=0) ** 2).mean()
    assert 0.7 * found < total < 2.0 * found


def test_quantization_steps_follow_units_and_mounting():
    """In a rotated frame the variances of the channels add."""
    telemetry = simulate_readings(
        SCENARIO, MOTIONS["turning"], 1, TrueErrors(gyro_step_deg_s=0.01), duration=300.0
    )
    np.testing.assert_allclose(telemetry.find_quantization_steps("gyro"), 0.01, rtol=1e-6)
    frame = telemetry.to_frame()
    for axis in "xyz":
        frame[f"gyro_{axis}"] = np.radians(frame[f"gyro_{axis}"])
    c = np.sqrt(0.5)
    turned = GyroChannels(
        unit="rad/s", dcm=((c, -c, 0.0), (c, c, 0.0), (0.0, 0.0, 1.0)), rotation="sensor-to-body"
    )
    read = read_telemetry(pd.DataFrame(frame), SCENARIO, TelemetryMapping(gyro=turned))
    np.testing.assert_allclose(read.find_quantization_steps("gyro"), 0.01, rtol=1e-6)
    assert (
        read.truncate(100.0).find_quantization_steps("gyro")[0]
        == read.find_quantization_steps("gyro")[0]
    )


@pytest.mark.parametrize(("motion", "step"), [("plan", 0.01), ("turning", 0.005)])
def test_quantized_gyro_is_calibrated_within_sigma(motion, step):
    """The noise is 0.0025 deg/s. Without the model, the bias was wrong by up to 9.6 sigma in a
    consistent calibration.
    """
    telemetry = simulate_readings(SCENARIO, MOTIONS[motion], 3, TrueErrors(gyro_step_deg_s=step))
    found = calibrate(SCENARIO, telemetry)
    check_errors([normalize_error(found, telemetry)], 0.98)
    assert found.notes == (f"gyro is quantized in steps of {step:g} deg/s, which add to its noise",)


def test_simulated_rates_have_declared_quantization():
    step = 0.005
    scenario = short(Scenario.paper(), 300.0)
    gyro = dataclasses.replace(scenario.gyro, quantization_deg_per_s=step)
    coarse = dataclasses.replace(scenario, gyro=gyro)
    rates, exact = (fly_plan(each, PLAN, 3).gyro_deg_s[1:] for each in (coarse, scenario))
    np.testing.assert_allclose(rates, step * np.round(exact / step), rtol=0, atol=1e-9)
