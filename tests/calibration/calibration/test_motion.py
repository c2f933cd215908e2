"""Bodies that rotate while the gyro averages, by the independent simulator."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import Scenario
from mgeo_calibration import Telemetry, calibrate
from mgeo_calibration.estimation.batch import build_batch
from mgeo_calibration.estimation.initial_attitude import accumulate_rotations
from mgeo_calibration.telemetry.gyro_samples import compute_mean_rates
from scipy.spatial.transform import Rotation

from .independent_simulator import (
    TrueErrors,
    coning_motion,
    constant_rates,
    integrate_motion,
    simulate_readings,
    tumbling_motion,
)
from .runs import PLAN, check_errors, normalize_error, short

SCENARIO = short(Scenario.cubesat_6u(), 3000.0)
MOTIONS = {
    "plan": constant_rates(PLAN),
    "1 deg/s at 0.5 rad/s": coning_motion(1.0, 0.5),
    "3 deg/s at 0.1 rad/s": coning_motion(3.0, 0.1),
    "3 deg/s at 0.2 rad/s": coning_motion(3.0, 0.2),
    "3 deg/s at 0.5 rad/s": coning_motion(3.0, 0.5),
    "tumble": tumbling_motion([0.10, 0.13, 0.05], [2.5, 3.0, 2.6], 3000.0),
}


def build_noiseless_telemetry(rate, times, given=None):
    """Return telemetry of a gyro without errors at some times, and of a Sun sensor with a fixed
    Sun.
    """
    angle, attitude = integrate_motion(rate, times)
    gyro = np.full((len(times), 3), np.nan)
    at = np.arange(len(times)) if given is None else given
    total = np.vstack([np.zeros(3), np.cumsum(angle, axis=0)])
    gyro[at[1:]] = np.degrees(np.diff(total[at], axis=0) / np.diff(times[at])[:, None])
    sun = attitude.inv().apply([1.0, 0.0, 0.0])
    telemetry = Telemetry(times=times, gyro_deg_s=gyro, sensors={"sun": sun, "mag": 4e4 * sun})
    return telemetry, attitude


def compute_drift(telemetry, attitude, straight=False):
    """Return the error of the integrated gyro attitude at every sample [deg], for linear or
    constant rates within a step.
    """
    data = build_batch(dataclasses.replace(SCENARIO, eclipse=False), telemetry)
    if straight:
        data = dataclasses.replace(data, rate_changes=np.zeros_like(data.rate_changes))
    carried = Rotation.from_matrix(accumulate_rotations(data, np.zeros((len(data.times), 18))))
    return np.degrees((attitude[0].inv() * attitude * carried.inv()).magnitude())


@pytest.mark.parametrize("name", [name for name in MOTIONS if name != "plan"])
def test_mean_rates_propagate_attitude(name):
    """The error is smaller than that of the gyro noise, and much larger with constant rates in a
    step.
    """
    telemetry, attitude = build_noiseless_telemetry(MOTIONS[name], np.arange(601.0))
    noise = SCENARIO.gyro.angle_random_walk_deg_per_sqrt_h * np.sqrt(600.0 / 3600.0)
    assert compute_drift(telemetry, attitude)[-1] < 0.5 * noise
    assert compute_drift(telemetry, attitude, straight=True)[-1] > 2.0 * noise


def test_gaps_and_steps_of_rates():
    """In gaps the rate is constant with a variance; elsewhere it is known."""
    rate, times = MOTIONS["3 deg/s at 0.1 rad/s"], np.arange(60.0)
    telemetry, _ = build_noiseless_telemetry(rate, times, np.delete(np.arange(60), [20, 21, 22]))
    data = build_batch(dataclasses.replace(SCENARIO, eclipse=False), telemetry)
    true = rate(times[1:]) - rate(times[:-1])
    guess = np.isin(np.arange(59), [19, 20, 21])
    assert not data.rate_changes[guess].any()
    assert np.abs(data.rate_changes - true)[~guess].max() < np.abs(true).max()
    far = np.abs(np.arange(59) - 20.5) > 7.0
    far[:3] = far[-3:] = False
    assert np.abs(data.rate_changes - true)[far].max() < 2e-3 * np.abs(true).max()
    assert (data.excess_angle_variance[:, 0] > 0.0).tolist() == guess.tolist()
    steadily, _ = build_noiseless_telemetry(constant_rates(PLAN), times)
    found = build_batch(dataclasses.replace(SCENARIO, eclipse=False), steadily)
    assert np.abs(found.rate_changes).max() < 1e-15


def test_mean_rates_from_instantaneous_rates():
    """For a rate that rotates at 0.5 rad/s, the error is 0.04 %; the trapezoidal rule has 2 %."""
    t = np.sort(np.append(np.arange(200.0), [50.3, 120.5]))
    rate = coning_motion(3.0, 0.5)
    exact = integrate_motion(rate, t)[0] / np.diff(t)[:, None]
    found = compute_mean_rates(t, rate(t))
    off = np.abs(found[1:] - exact)
    assert off[3:-3].max() < 4e-4 * np.radians(3.0)
    assert np.abs(0.5 * (rate(t[1:]) + rate(t[:-1])) - exact).max() > 0.015 * np.radians(3.0)
    gap = np.delete(np.arange(len(t)), [100, 101, 102])
    after = compute_mean_rates(t[gap], rate(t)[gap])[100]
    assert np.abs(after - exact[102]).max() < 0.03 * np.radians(3.0)


def count_consistent(name, craft, seeds, mapping=None, worst=4.0):
    """Return the number of consistent runs, after a check that the errors agree with the
    covariances.
    """
    found, supported = [], 0
    for seed in seeds:
        telemetry = simulate_readings(SCENARIO, MOTIONS[name], seed, craft)
        calibration = calibrate(SCENARIO, telemetry.to_frame() if mapping else telemetry, mapping)
        found.append(normalize_error(calibration, telemetry))
        supported += calibration.is_consistent
    check_errors(found, worst=worst)
    return supported


@pytest.mark.cases(1)
@pytest.mark.parametrize("name", ["3 deg/s at 0.5 rad/s", "tumble"])
def test_moving_body_is_calibrated_within_sigma(name):
    """With constant rates in a step, the gyro bias was wrong by up to 20 sigma in a consistent
    calibration.
    """
    assert count_consistent(name, TrueErrors(), [1]) == 1
