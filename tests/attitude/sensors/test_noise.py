"""Noise per axis, given by one number or by three."""

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


SCALAR_NOISE = {"angle_random_walk_deg_per_sqrt_h": 0.2, "rate_random_walk": 3e-7}


def build_scenario(gyro=SCALAR_NOISE, **mag):
    table = {"preset": "paper", "duration": 400.0, "convergence": {"window": 60.0}, "gyro": gyro}
    return Scenario.from_dict(
        table | {"sensors": [{"kind": "sun-sensor"}, {"kind": "magnetometer", **mag}]}
    )


def test_three_equal_numbers_are_equivalent_to_one_number():
    gyro = {key: [value] * 3 for key, value in SCALAR_NOISE.items()}
    scalar, per_axis = build_scenario(noise_nt=500.0), build_scenario(gyro, noise_nt=[500.0] * 3)
    objectives = [AttitudeManeuverProblem(each).evaluate(DESIGN) for each in (scalar, per_axis)]
    assert objectives[0].tolist() == objectives[1].tolist()
    assert Scenario.from_toml(per_axis.to_toml()) == per_axis
    assert Scenario.from_dict(per_axis.to_dict()) == per_axis


def test_covariance_with_noise_per_axis_equals_filterpy():
    gyro = {
        "angle_random_walk_deg_per_sqrt_h": [0.01, 5.0, 0.3],
        "bias_instability_deg_per_h": [1.0, 5.0, 200.0],
        "bias_decay": 1e-3,
    }
    scenario = build_scenario(gyro, noise_nt=[100.0, 500.0, 2000.0])
    comparison = compare_filters(FilterModel.from_scenario(scenario), DESIGN)
    assert comparison.has_equal_ends
    assert comparison.max_difference < 1e-9


def test_scale_noise_multiplies_noise_of_every_axis():
    per_axis = scale_noise(Magnetometer(noise_nt=(1.0, 2.0, 3.0)), 2.0)
    assert per_axis.noise_nt == (2.0, 4.0, 6.0)
    assert scale_noise(SunSensor(noise_deg=1.0), 0.5).noise_deg == 0.5
    gyro = Gyro(angle_random_walk_deg_per_sqrt_h=(0.1, 0.2, 0.3))
    density = scale_noise(gyro, 2.0).compute_noise_density()
    assert density["theta"][2] == (np.radians(0.6) / 60.0) ** 2
    scalar = dataclasses.replace(per_axis, noise_nt=4.0)
    assert scalar.noise_sigmas() == pytest.approx((per_axis.noise_sigmas()[1],) * 3, rel=1e-15)


@pytest.mark.parametrize("noise", [[1.0, 2.0], [1.0, 2.0, 0.0], [1.0, 2.0, "3"], "500", 0.0])
def test_noise_other_than_one_or_three_positive_numbers_is_rejected(noise):
    with pytest.raises(InvalidValue, match=r"sensors\[1\]\.noise_nt = .*expected .*> 0.*\[nT\]"):
        build_scenario(noise_nt=noise)
