"""Noise of each axis, where one number stands for all."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import (
    AttitudeManeuverProblem,
    FilterModel,
    Gyro,
    Magnetometer,
    Scenario,
    SunSensor,
    compare_filters,
)
from mgeo_attitude.sensors.base import scale_noise
from mgeo_attitude.settings.errors import InvalidValue

DESIGN = np.array([[0.5, 0.3, -0.2, 100.0, -0.3, 0.6, 0.2, 100.0, 0.2, -0.4, 0.7, 100.0]])


ONE = {"angle_random_walk_deg_per_sqrt_h": 0.2, "rate_random_walk": 3e-7}


def scenario(gyro=ONE, **mag):
    table = {"preset": "paper", "duration": 400.0, "convergence": {"window": 60.0}, "gyro": gyro}
    return Scenario.from_dict(
        table | {"sensors": [{"kind": "sun-sensor"}, {"kind": "magnetometer", **mag}]}
    )


def test_three_numbers_alike_are_one():
    alike = {key: [value] * 3 for key, value in ONE.items()}
    one, three = scenario(noise_nt=500.0), scenario(alike, noise_nt=[500.0] * 3)
    found = [AttitudeManeuverProblem(each).evaluate(DESIGN) for each in (one, three)]
    assert found[0].tolist() == found[1].tolist()
    assert Scenario.from_toml(three.to_toml()) == three
    assert Scenario.from_dict(three.to_dict()) == three


def test_each_axis_counts_with_its_own_noise():
    """As filterpy has it."""
    gyro = {
        "angle_random_walk_deg_per_sqrt_h": [0.01, 5.0, 0.3],
        "bias_instability_deg_per_h": [1.0, 5.0, 200.0],
        "bias_decay": 1e-3,
    }
    uneven = scenario(gyro, noise_nt=[100.0, 500.0, 2000.0])
    found = compare_filters(FilterModel.from_scenario(uneven), DESIGN)
    assert found.has_equal_ends
    assert found.max_difference < 1e-9


def test_noise_is_scaled_axis_by_axis():
    louder = scale_noise(Magnetometer(noise_nt=(1.0, 2.0, 3.0)), 2.0)
    assert louder.noise_nt == (2.0, 4.0, 6.0)
    assert scale_noise(SunSensor(noise_deg=1.0), 0.5).noise_deg == 0.5
    walks = Gyro(angle_random_walk_deg_per_sqrt_h=(0.1, 0.2, 0.3))
    assert (
        scale_noise(walks, 2.0).compute_noise_density()["theta"][2] == (np.radians(0.6) / 60.0) ** 2
    )
    even = dataclasses.replace(louder, noise_nt=4.0)
    assert even.noise_sigmas() == pytest.approx((louder.noise_sigmas()[1],) * 3, rel=1e-15)


@pytest.mark.parametrize("noise", [[1.0, 2.0], [1.0, 2.0, 0.0], [1.0, 2.0, "3"], "500", 0.0])
def test_what_is_neither_a_number_nor_three_is_refused(noise):
    words = r"sensors\[1\]\.noise_nt = .*a number > 0 or a list of 3 x \(a number > 0\) \[nT\]"
    with pytest.raises((InvalidValue), match=words):
        scenario(noise_nt=noise)
