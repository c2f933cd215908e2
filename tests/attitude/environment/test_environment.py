"""Environment compared with an independent computation, and invalid environments."""

from __future__ import annotations

import dataclasses
from datetime import UTC, datetime, timedelta
from typing import Any

import erfa
import numpy as np
import ppigrf
import pytest
from mgeo_attitude import FilterModel
from mgeo_attitude.environment.environment import Environment
from mgeo_attitude.environment.times import compute_julian_dates
from mgeo_attitude.scenario import Convergence, Scenario

EPOCH = datetime(2020, 6, 19, 21, 30, tzinfo=UTC)  # The run includes midnight.


@pytest.fixture(scope="module")
def scenario() -> Scenario:
    return dataclasses.replace(Scenario.paper(), epoch=EPOCH, step=20.0, duration=12000.0)


@pytest.fixture(scope="module")
def environment(scenario: Scenario) -> Environment:
    return Environment.from_scenario(scenario)


def compute_geodetic_field(position: np.ndarray, date: datetime, seconds: float) -> np.ndarray:
    """Return the field at one GCRS position by geodetic coordinates, for its exact date."""
    at = compute_julian_dates(date, [seconds])
    to_itrs = erfa.c2t06a(at.midnight, at.tt[0], at.midnight, at.ut[0], 0.0, 0.0)
    longitude, latitude, height = erfa.gc2gd(1, to_itrs @ position)
    moment = (date + timedelta(seconds=seconds)).replace(tzinfo=None)
    east, north, up = ppigrf.igrf(np.degrees(longitude), np.degrees(latitude), height / 1e3, moment)
    to_north_east_up = erfa.rz(np.pi, erfa.ry(np.pi / 2 - latitude, erfa.rz(longitude, np.eye(3))))
    local = np.array([north[0], -east[0], up[0]])
    return (to_north_east_up @ to_itrs).T @ local


@pytest.mark.slow
def test_field_equals_geodetic_computation(scenario: Scenario, environment: Environment) -> None:
    for k in range(0, scenario.n_steps + 1, 40):
        slow = compute_geodetic_field(environment.position[k], EPOCH, float(environment.times[k]))
        np.testing.assert_allclose(environment.field[k], slow, rtol=0.0, atol=0.1)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"epoch": EPOCH + timedelta(days=1)}, r"epoch = '2020-06-19T21:30:00Z': .*'2020-06-20T"),
        (
            {"orbit": dataclasses.replace(Scenario.paper().orbit, raan_deg=1.5)},
            r"orbit\.raan_deg = 230\.297: expected the scenario's 1\.5",
        ),
    ],
)
def test_environment_of_other_scenario_is_rejected(
    scenario: Scenario, environment: Environment, changes: dict[str, Any], message: str
) -> None:
    with pytest.raises(ValueError, match=rf"^environment\.{message}"):
        FilterModel.from_scenario(dataclasses.replace(scenario, **changes), environment)


def test_user_defined_environment_needs_times_of_scenario(scenario: Scenario) -> None:
    environment = Environment(**build_arrays())
    short = dataclasses.replace(
        scenario, step=1.0, duration=1.0, convergence=Convergence(window=1.0)
    )
    assert FilterModel.from_scenario(short, environment).n_steps == 1
    with pytest.raises(ValueError, match=r"times: 2 samples from 0 to 1 s: .* 601, one every 20 s"):
        FilterModel.from_scenario(scenario, environment)


def build_arrays() -> dict[str, Any]:
    return {
        "times": [0.0, 1.0],
        "position": np.full((2, 3), 7e6),
        "velocity": np.ones((2, 3)),
        "sun": [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        "field": np.ones((2, 3)),
        "sunlit": [True, False],
    }


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        (
            "position",
            np.ones((3, 3)),
            r"position: .*shape \(2, 3\) of finite numbers",
        ),
        ("velocity", np.full((2, 3), np.nan), "velocity: expected .* finite"),
        ("times", [1.0, 1.0], "times: .*increasing"),
        ("sun", np.ones((2, 3)), "sun: expected unit vectors"),
    ],
)
def test_invalid_arrays_are_rejected(name: str, value: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Environment(**{**build_arrays(), name: value})
