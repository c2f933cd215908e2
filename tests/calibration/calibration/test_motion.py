"""Bodies that turn while the gyro averages, by a simulation of its own."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import Scenario
from mgeo_calibration import Telemetry, calibrate
from mgeo_calibration.estimation.batch import build_batch
from mgeo_calibration.estimation.initial_attitude import accumulate_rotations
from mgeo_calibration.telemetry.gyro_samples import compute_mean_rates
from scipy.spatial.transform import Rotation

from .flights import PLAN, check_claimed, normalized, short
from .independent import Craft, coning, fly, steady, tumble, turned

SCENARIO = short(Scenario.cubesat_6u(), 3000.0)
MOTIONS = {
    "plan": steady(PLAN),
    "1 deg/s at 0.5 rad/s": coning(1.0, 0.5),
    "3 deg/s at 0.1 rad/s": coning(3.0, 0.1),
    "3 deg/s at 0.2 rad/s": coning(3.0, 0.2),
    "3 deg/s at 0.5 rad/s": coning(3.0, 0.5),
    "tumble": tumble([0.10, 0.13, 0.05], [2.5, 3.0, 2.6], 3000.0),
}


def without_noise(rate, times, given=None):
    """Telemetry of a gyro without errors at some of the times, and of a Sun that stands still."""
    angle, attitude = turned(rate, times)
    gyro = np.full((len(times), 3), np.nan)
    at = np.arange(len(times)) if given is None else given
    total = np.vstack([np.zeros(3), np.cumsum(angle, axis=0)])
    gyro[at[1:]] = np.degrees(np.diff(total[at], axis=0) / np.diff(times[at])[:, None])
    sun = attitude.inv().apply([1.0, 0.0, 0.0])
    telemetry = Telemetry(times=times, gyro_deg_s=gyro, sensors={"sun": sun, "mag": 4e4 * sun})
    return telemetry, attitude


def drift(telemetry, attitude, straight=False):
    """By what the gyro is off at every sample [deg], if its rate changes in steps or not at all."""
    data = build_batch(dataclasses.replace(SCENARIO, eclipse=False), telemetry)
    if straight:
        data = dataclasses.replace(data, rate_changes=np.zeros_like(data.rate_changes))
    carried = Rotation.from_matrix(accumulate_rotations(data, np.zeros((len(data.times), 18))))
    return np.degrees((attitude[0].inv() * attitude * carried.inv()).magnitude())


@pytest.mark.parametrize("name", [name for name in MOTIONS if name != "plan"])
def test_mean_rates_carry_the_attitude(name):
    """By less than the gyro's noise does; as if they were constant in a step, by far more."""
    telemetry, attitude = without_noise(MOTIONS[name], np.arange(601.0))
    noise = SCENARIO.gyro.angle_random_walk_deg_per_sqrt_h * np.sqrt(600.0 / 3600.0)
    assert drift(telemetry, attitude)[-1] < 0.5 * noise
    assert drift(telemetry, attitude, straight=True)[-1] > 2.0 * noise


def test_gaps_and_jumps_of_the_gyro():
    """Where samples are missing the rate is a guess, whose change is none; beyond, it is known."""
    rate, times = MOTIONS["3 deg/s at 0.1 rad/s"], np.arange(60.0)
    telemetry, _ = without_noise(rate, times, np.delete(np.arange(60), [20, 21, 22]))
    data = build_batch(dataclasses.replace(SCENARIO, eclipse=False), telemetry)
    true = rate(times[1:]) - rate(times[:-1])
    guess = np.isin(np.arange(59), [19, 20, 21])
    assert not data.rate_changes[guess].any()
    assert np.abs(data.rate_changes - true)[~guess].max() < np.abs(true).max()
    far = np.abs(np.arange(59) - 20.5) > 7.0
    far[:3] = far[-3:] = False
    assert np.abs(data.rate_changes - true)[far].max() < 2e-3 * np.abs(true).max()
    assert (data.excess_angle_variance[:, 0] > 0.0).tolist() == guess.tolist()
    steadily, _ = without_noise(steady(PLAN), times)
    found = build_batch(dataclasses.replace(SCENARIO, eclipse=False), steadily)
    assert np.abs(found.rate_changes).max() < 1e-15


def test_means_of_rates_at_the_samples():
    """Of a rate that turns at 0.5 rad/s the trapezoidal rule loses 2 %; here 0.04 % are lost."""
    t = np.sort(np.append(np.arange(200.0), [50.3, 120.5]))
    rate = coning(3.0, 0.5)
    exact = turned(rate, t)[0] / np.diff(t)[:, None]
    found = compute_mean_rates(t, rate(t))
    off = np.abs(found[1:] - exact)
    assert off[3:-3].max() < 4e-4 * np.radians(3.0)
    assert np.abs(0.5 * (rate(t[1:]) + rate(t[:-1])) - exact).max() > 0.015 * np.radians(3.0)
    gap = np.delete(np.arange(len(t)), [100, 101, 102])
    after = compute_mean_rates(t[gap], rate(t)[gap])[100]
    assert np.abs(after - exact[102]).max() < 0.03 * np.radians(3.0)


def checked(name, craft, seeds, mapping=None, worst=4.0):
    """How many flights are supported, of which errors are as large as is claimed."""
    found, supported = [], 0
    for seed in seeds:
        telemetry = fly(SCENARIO, MOTIONS[name], seed, craft)
        calibration = calibrate(SCENARIO, telemetry.to_frame() if mapping else telemetry, mapping)
        found.append(normalized(calibration, telemetry))
        supported += calibration.is_consistent
    check_claimed(found, worst=worst)
    return supported


@pytest.mark.cases(1)
@pytest.mark.parametrize("name", ["3 deg/s at 0.5 rad/s", "tumble"])
def test_a_body_in_motion_is_calibrated_as_claimed(name):
    """The gyro's bias was off by up to 20 sigma, supported by the innovations."""
    assert checked(name, Craft(), [1]) == 1
