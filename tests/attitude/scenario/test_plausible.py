"""What looks like a slip is told; what cannot be is refused."""

from __future__ import annotations

import dataclasses
from datetime import timedelta

import pytest
from mgeo_attitude import Scenario
from mgeo_attitude.scenario import TLEOrbit
from mgeo_attitude.scenario.actuators import Magnetorquers, Wheels
from mgeo_attitude.scenario.toml import PRESETS
from mgeo_attitude.scenario.validity import ImplausibleValue, find_implausible_values
from mgeo_attitude.settings.errors import InvalidValue

from .test_orbit import ISS_1, ISS_2


@pytest.mark.parametrize("name", PRESETS)
def test_nothing_of_a_preset_is_implausible(name: str) -> None:
    assert find_implausible_values(Scenario.from_dict({"preset": name})) == ()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "[wheels]\ninertia = [18000.0, 15000.0, 12000.0]",
            "wheels.inertia = 18000 kg m²: the usual range is",
        ),
        (
            "[[sensors]]\nkind = 'magnetometer'\nnoise_nt = 1e-7",
            "sensors[0].noise_nt = 1e-07 nT: the us",
        ),
        ("[[sensors]]\nkind = 'star-tracker'\nnoise_arcsec = 0.003", "sensors[0].noise_arcsec"),
        (
            "[gyro]\nangle_random_walk_deg_per_sqrt_h = 36.0",
            "gyro.angle_random_walk_deg_per_sqrt_h",
        ),
        ("[orbit]\nsemi_major_axis = 26560e3", "orbit: 4.2 Earth radii from the Earth's center"),
        ("[orbit]\nsemi_major_axis = 6450e3", "orbit: down to 6"),
    ],
)
def test_a_file_that_says_so_is_read_and_told(text: str, message: str) -> None:
    with pytest.warns(ImplausibleValue) as told:
        scenario = Scenario.from_toml(f'preset = "paper"\n{text}\n')
    assert [line for line in find_implausible_values(scenario) if line.startswith(message)]
    assert any(message in str(each.message) for each in told)


def test_an_element_set_ages_within_a_run() -> None:
    pytest.importorskip("sgp4")
    orbit = TLEOrbit(line1=ISS_1, line2=ISS_2)
    scenario = dataclasses.replace(
        Scenario.paper(), orbit=orbit, epoch=orbit.element_epoch + timedelta(days=29.9)
    )
    (line,) = find_implausible_values(scenario)
    assert "at the end of the run the element set is 30.0 days old" in line
    assert find_implausible_values(dataclasses.replace(scenario, epoch=orbit.element_epoch)) == ()


@pytest.mark.parametrize("of", [Wheels, lambda **k: Magnetorquers(max_dipole=(1.0, 1.0, 1.0), **k)])
def test_no_body_has_a_moment_beyond_the_sum_of_the_others(of) -> None:
    with pytest.raises(InvalidValue, match=r"inertia = .*none exceeds the sum of the"):
        of(inertia=(0.1, 0.2, 0.31))
    of(inertia=(0.1, 0.2, 0.3))  # a plate
    with pytest.raises(InvalidValue, match=r"other two, not 0.0"):
        of(inertia=(0.2, 0.2, 0.2), products_of_inertia=(0.12, 0.12, -0.05))
