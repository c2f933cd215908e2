"""Pointing laws, compared with the radial frame of brahe and with their definitions."""

from __future__ import annotations

import brahe
import numpy as np
import pytest
from mgeo_attitude import Environment, Scenario
from mgeo_attitude.environment.directions import SatelliteState, compute_pointing_attitudes
from mgeo_attitude.scenario import InitialConditions
from mgeo_attitude.settings.errors import InvalidValue
from scipy.spatial.transform import Rotation

AXES = [(0.0, 0.0, 1.0), (0.0, 0.0, -1.0), (1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.6, 0.0, 0.8)]


@pytest.fixture(scope="module")
def at() -> SatelliteState:
    """States along an eccentric orbit, where velocity and horizon differ."""
    table = Scenario.paper().to_dict() | {"duration": 43200.0, "step": 10.0}
    table["orbit"] |= {"semi_major_axis": 9e6, "eccentricity": 0.2}
    scenario = Scenario.from_dict(table)
    return SatelliteState.from_times(scenario, scenario.times)


def test_satellite_state_equals_environment() -> None:
    scenario = Scenario.from_dict({"preset": "cubesat_6u", "duration": 1000.0})
    environment = Environment.from_scenario(scenario)
    place = SatelliteState.from_times(scenario, scenario.times[::100])
    for name, actual in place._asdict().items():
        np.testing.assert_array_equal(actual, getattr(environment, name)[::100])


def test_nadir_pointing_equals_radial_frame_of_brahe(at: SatelliteState) -> None:
    """The frame is LVLH: z down, x along track, y opposite to the orbit normal."""
    actual = InitialConditions(pointing="nadir").compute_attitude(at)
    for k in (0, 17, 300, 4000):
        radial, along, normal = brahe.rotation_eci_to_rtn(np.append(at.position[k], at.velocity[k]))
        expected = [along, -np.array(normal), -np.array(radial)]
        np.testing.assert_allclose(actual[k], expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize("axis", AXES)
@pytest.mark.parametrize("clock", [0.0, 30.0, -170.0])
@pytest.mark.parametrize("pointing", ["nadir", "velocity", "sun"])
def test_axis_points_at_target_with_clock_angle(
    at: SatelliteState, pointing: str, axis: tuple[float, float, float], clock: float
) -> None:
    law = InitialConditions(pointing=pointing, axis=axis, clock_deg=clock)
    normal = np.cross(at.position, at.velocity)
    target, toward = {
        "nadir": (-at.position, at.velocity),
        "velocity": (at.velocity, -at.position),
        "sun": (at.sun, normal),
    }[pointing]
    second = [1.0, 0.0, 0.0] if abs(axis[2]) > 0.71 else [0.0, 0.0, 1.0]
    C = law.compute_attitude(at)
    np.testing.assert_allclose(C @ C.swapaxes(1, 2), np.repeat([np.eye(3)], len(C), 0), atol=1e-14)
    np.testing.assert_allclose(np.linalg.det(C), 1.0)
    for k in (0, 1000, 4321 - 1):
        reached = C[k].T @ np.array(axis)
        np.testing.assert_allclose(reached, target[k] / np.linalg.norm(target[k]), atol=1e-14)
        # After rotation back by the clock angle, the second axis is closest to its reference.
        back = Rotation.from_rotvec(-np.radians(clock) * reached)
        turns = np.radians(np.linspace(-180.0, 180.0, 3601))[:, None] * reached
        near = Rotation.from_rotvec(turns).apply(back.apply(C[k].T @ second)) @ toward[k]
        assert np.argmax(near) == 1800


@pytest.mark.parametrize("pointing", ["nadir", "velocity", "sun"])
def test_law_rate_equals_difference_of_attitudes(at: SatelliteState, pointing: str) -> None:
    """The law neglects the motion of the Sun by one degree per day."""
    law = InitialConditions(pointing=pointing, axis=(0.6, 0.0, 0.8), clock_deg=25.0)
    C, rates = law.compute_attitude(at), law.compute_law_rate(at)
    turns = -Rotation.from_matrix(C[2:] @ C[:-2].swapaxes(1, 2)).as_rotvec() / 20.0
    assert np.abs(turns - rates[1:-1]).max() < (3e-7 if pointing == "sun" else 2e-8)
    assert (np.abs(rates).max() > 5e-4) == (pointing != "sun")


def test_target_parallel_to_clock_reference_is_rejected() -> None:
    along = np.array([[0.0, 0.0, 1.0]])
    with pytest.raises(ValueError, match="parallel"):
        compute_pointing_attitudes(np.eye(3)[2], along, -3.0 * along, 0.0)
    orbit = np.zeros(1), np.array([[7e6, 0.0, 0.0]]), np.array([[0.0, 7e3, 0.0]])
    with pytest.raises(InvalidValue, match=r"initial\.pointing = 'sun': expected.*parallel"):
        InitialConditions(pointing="sun").compute_attitude(
            SatelliteState(*orbit, along, np.array([True]))
        )


def test_quaternion_and_axes_give_same_attitude(at: SatelliteState) -> None:
    """Both represent a rotation of the GCRF axes to the body axes by 90 degrees about z."""
    half = np.sqrt(0.5)
    by_quaternion = InitialConditions(quaternion=(0.0, 0.0, half, half))
    axes = ((0.0, 1.0, 0.0), (-1.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    by_axes = InitialConditions(axes=axes)
    for law in (by_quaternion, by_axes):
        actual = law.compute_attitude(at)
        assert actual.shape == (len(at.position), 3, 3)
        np.testing.assert_allclose(actual[[0, -1]], [axes, axes], rtol=0, atol=1e-15)
        assert not law.compute_rate(at).any()
    typed = InitialConditions(quaternion=(0.0, 0.0, 0.7071, 0.7071))
    np.testing.assert_allclose(typed.compute_attitude(at)[0], axes, rtol=0, atol=1e-15)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"clock_deg": 5}, "clock_deg = 5.0: expected no value with pointing = 'inertial'"),
        (
            {"pointing": "sun", "quaternion": (0, 0, 0, 1)},
            "quaternion = (0.0, 0.0, 0.0, 1.0): expected no value with pointing = 'sun'",
        ),
        (
            {"axes": ((1, 0, 0), (0, 1, 0), (0, 0, -1))},
            "axes = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, -1.0)): expected three "
            "right-handed unit vectors",
        ),
    ],
)
def test_contradictory_keys_are_rejected(values: dict[str, object], message: str) -> None:
    with pytest.raises(InvalidValue) as caught:
        InitialConditions(**values)
    assert str(caught.value).startswith(message)
