"""Warnings about implausible values, and rejection of impossible values."""

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
def test_presets_have_no_implausible_values(name: str) -> None:
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
        ("[orbit]\nsemi_major_axis = 6450e3", "orbit: down to an altitude of 6"),
    ],
)
def test_file_with_implausible_value_is_read_with_warning(text: str, message: str) -> None:
    with pytest.warns(ImplausibleValue) as warnings:
        scenario = Scenario.from_toml(f'preset = "paper"\n{text}\n')
    assert [line for line in find_implausible_values(scenario) if line.startswith(message)]
    assert any(message in str(each.message) for each in warnings)


def test_element_set_too_old_at_end_of_run_is_reported() -> None:
    pytest.importorskip("sgp4")
    orbit = TLEOrbit(line1=ISS_1, line2=ISS_2)
    scenario = dataclasses.replace(
        Scenario.paper(), orbit=orbit, epoch=orbit.element_epoch + timedelta(days=29.9)
    )
    (line,) = find_implausible_values(scenario)
    assert "at the end of the run the element set is 30.0 days old" in line
    assert find_implausible_values(dataclasses.replace(scenario, epoch=orbit.element_epoch)) == ()


@pytest.mark.parametrize(
    "build", [Wheels, lambda **k: Magnetorquers(max_dipole=(1.0, 1.0, 1.0), **k)]
)
def test_moment_of_inertia_above_sum_of_others_is_rejected(build) -> None:
    with pytest.raises(InvalidValue, match=r"inertia = .*none exceeds the sum of the"):
        build(inertia=(0.1, 0.2, 0.31))
    build(inertia=(0.1, 0.2, 0.3))  # The limiting case is a plate.
    with pytest.raises(InvalidValue, match=r"other two, not 0.0"):
        build(inertia=(0.2, 0.2, 0.2), products_of_inertia=(0.12, 0.12, -0.05))
