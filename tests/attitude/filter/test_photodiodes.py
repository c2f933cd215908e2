"""Photodiodes: cosine law, information of a measurement, and lower bound."""

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest
from mgeo_attitude import (
    EnvironmentErrors,
    Gyro,
    Magnetometer,
    NoLowerBoundError,
    Photodiode,
    Scenario,
    Suite,
    compute_lower_bound,
)
from mgeo_attitude.lower_bound.faces import bound_joint_information
from scipy.spatial.transform import Rotation

V = Rotation.random(20, random_state=1).as_matrix()[:, 0]
FACES = {"px": (1, 0, 0), "mx": (-1, 0, 0), "py": (0, 1, 0), "my": (0, -1, 0), "pz": (0, 0, 1),
         "mz": (0, 0, -1)}  # fmt: skip


def build_cube(**keys):
    """Return a photodiode on each of six faces."""
    return tuple(
        Photodiode(name=name, normal=tuple(map(float, normal)), **keys)
        for name, normal in FACES.items()
    )


def scenario(*sensors, **changes):
    options = {"duration": 3000.0, "eclipse": True} | changes
    return dataclasses.replace(Scenario.paper(), sensors=sensors, **options)


def build_errors(sensitivity, light=(0.0, 0.0, 0.0), **more):
    return SimpleNamespace(
        sensitivity=np.array(sensitivity),
        gradient=[np.array(light)],
        to_body=lambda vector: vector,
        **more,
    )


def test_photodiode_measures_cosine_with_gain_and_tilt_errors():
    diode = Photodiode(normal=(0.0, 3.0, 4.0))
    n = np.array([0.0, 0.6, 0.8])
    zero = np.zeros(3)
    np.testing.assert_allclose(
        diode.predict_measurement(build_errors(zero), V)[:, 0], V @ n, atol=1e-15
    )
    gain = diode.predict_measurement(build_errors([0.0, 0.0, 0.1]), V)[:, 0]
    np.testing.assert_allclose(gain, 1.1 * (V @ n), atol=1e-15)
    tilted = diode.axes[2] + 1e-3 * diode.axes[0]
    actual = diode.predict_measurement(build_errors([1e-3, 0.0, 0.0]), V)[:, 0]
    np.testing.assert_allclose(actual, V @ tilted, atol=1e-15)
    np.testing.assert_allclose(diode.axes @ diode.axes.T, np.eye(3), atol=1e-15)
    assert np.linalg.det(diode.axes) == pytest.approx(1.0)


def test_light_from_behind_is_not_measured():
    diode, light = Photodiode(normal=(1.0, 0.0, 0.0)), np.array([[0.2, 0.1, 0.0], [-0.2, 0.1, 0.0]])
    actual = diode.predict_measurement(
        build_errors(np.zeros(3), light, albedo=np.array([0.01, 0.0, 0.0])), V[:2]
    )
    np.testing.assert_allclose(actual[:, 0], V[:2, 0] + [0.21, 0.0], atol=1e-15)
    blind = dataclasses.replace(diode, includes_albedo=False)
    np.testing.assert_array_equal(
        blind.predict_measurement(build_errors(np.zeros(3), light), V)[:, 0], V[:, 0]
    )


@pytest.mark.parametrize("light", [(0.0, 0.0, 0.0), (0.05, 0.2, -0.1)])
def test_measurement_matrix_is_derivative_of_measurement(light):
    """The derivatives are central differences."""
    diode, light = Photodiode(normal=(0.3, -1.0, -1.0)), np.array(light)
    suite = Suite(Gyro(), (diode,), EnvironmentErrors(albedo=0.03))
    H = suite.measurement_matrix(diode, V, gradient=[np.broadcast_to(light, V.shape)])[:, 0]
    own, world = (
        3 * suite.blocks.index(b) for b in ("diode.sensitivity", "environment_errors.albedo")
    )
    h = 1e-6
    for k in range(3):
        e = h * np.eye(3)[k]
        zero = np.zeros(3)

        def reads(turn=zero, sensitivity=zero, albedo=zero):
            back = Rotation.from_rotvec(-turn)
            x = build_errors(sensitivity, back.apply(light), albedo=albedo)
            x.to_body = back.apply
            return diode.predict_measurement(x, back.apply(V))[:, 0]

        for first, name in ((0, "turn"), (own, "sensitivity"), (world, "albedo")):
            slope = (reads(**{name: e}) - reads(**{name: -e})) / (2.0 * h)
            np.testing.assert_allclose(H[:, first + k], slope, atol=1e-9)


def test_three_perpendicular_diodes_equal_direction_sensor():
    """For three perpendicular normals n, the sum of (n × s)(n × s)ᵀ is I - s sᵀ."""
    r = 0.02
    total = 0.0
    for diode in build_cube(relative_noise=r)[::2]:
        H = Suite(Gyro(), (diode,)).measurement_matrix(diode, V, gradient=[0.0 * V])[:, 0, :3]
        total = total + H[:, :, None] * H[:, None] / r**2
    np.testing.assert_allclose(
        total, (np.eye(3) - V[:, :, None] * V[:, None]) / r**2, atol=1e-9 / r**2
    )


def test_joint_information_is_below_bound():
    """The maximum is taken over 50,000 directions, for diodes with different noise and cones."""
    rng = np.random.default_rng(5)
    diodes = [
        Photodiode(
            name=str(k),
            normal=tuple(rng.standard_normal(3)),
            relative_noise=float(rng.uniform(0.01, 0.03)),
            half_angle_deg=float(rng.uniform(40.0, 85.0)),
        )
        for k in range(7)
    ]
    s = rng.standard_normal((50_000, 3))
    s /= np.linalg.norm(s, axis=1, keepdims=True)
    J = np.zeros((len(s), 3, 3))
    for diode in diodes:
        n = diode.axes[2]
        row = np.cross(n, s) / diode.relative_noise
        row[s @ n < np.cos(np.radians(diode.half_angle_deg))] = 0.0
        J += row[:, :, None] * row[:, None]
    most = np.linalg.eigvalsh(J)[:, -1].max()
    assert most < bound_joint_information(diodes) < 1.15 * most
    assert 1.0 < bound_joint_information(build_cube(relative_noise=1.0)) < 1.06


@pytest.mark.parametrize(
    ("keys", "environment_errors", "message"),
    [
        ({}, EnvironmentErrors(earth_albedo=0.3), "px: no lower bound .* includes_albedo = false"),
        ({"initial_latency_s": 0.1}, EnvironmentErrors(), "px.latency depends on the attitude"),
    ],
)
def test_missing_lower_bound_is_explained(keys, environment_errors, message):
    with pytest.raises(NoLowerBoundError, match=message):
        compute_lower_bound(
            scenario(*build_cube(**keys), Magnetometer(), environment_errors=environment_errors)
        )
