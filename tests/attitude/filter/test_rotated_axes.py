"""Rotation of the initial attitude, compared with a permutation of the body axes."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import FilterModel, Magnetometer, Scenario, StarTracker, evaluate
from mgeo_attitude.scenario import Convergence, PathConstraint, Wheels

from .agreement import designs


def build_satellite(renamed):
    """Return a scenario with all body-fixed vectors permuted by the function `renamed`."""
    xyz = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    limits = [
        PathConstraint(
            name=f"{reference} {sense}",
            reference=reference,
            sense=sense,
            boresight=renamed((0.2, -0.5, 1.0)),
            half_angle_deg=80.0,
            attitude_sigmas=sigmas,
        )
        for reference, sense, sigmas in (
            ("sun", "keep-out", 0.0),
            ("earth", "keep-in", 2.0),
            ("moon", "keep-out", 1.0),
            ("velocity", "keep-in", 0.0),
        )
    ]
    tracker = StarTracker(
        boresight=renamed((1.0, -0.4, 0.3)), earth_exclusion_deg=15.0, sun_exclusion_deg=30.0
    )
    wheels = Wheels(
        inertia=renamed((0.13, 0.10, 0.05)),
        axes=(*(renamed(axis) for axis in xyz), renamed((1.0, 1.0, -1.0))),
        initial_momentum=(1e-3, -5e-4, 2e-4, 3e-4),
        residual_dipole=renamed((0.01, -0.02, 0.03)),
        gravity_gradient=True,
        max_torque=2e-4,
        max_momentum=1e-2,
        ramp_share=0.5,
    )
    return dataclasses.replace(
        Scenario.cubesat_6u(),
        duration=1500.0,
        eclipse=False,
        convergence=Convergence(window=60.0),
        sensors=(tracker, Magnetometer()),
        path_constraints=tuple(limits),
        wheels=wheels,
    )


@pytest.mark.slow
def test_result_does_not_depend_on_names_of_body_axes():
    """The axes x, y, z of the first satellite are z, x, y of the second."""
    order = [1, 2, 0]

    def renamed(v):
        return tuple(v[k] for k in order)

    original_model = FilterModel.from_scenario(build_satellite(lambda v: v))
    permuted_model = FilterModel.from_scenario(build_satellite(renamed)).rotate_initial_attitude(
        np.eye(3)[:, order]
    )
    X = designs(np.random.default_rng(7), 5, max_duration=200.0)
    X[:, np.arange(12) % 4 != 3] *= 0.5
    maneuvers = X.reshape(5, 3, 4).copy()
    maneuvers[:, :, :3] = maneuvers[:, :, order]
    original, permuted = (
        evaluate(original_model, X),
        evaluate(permuted_model, maneuvers.reshape(5, 12)),
    )
    np.testing.assert_array_equal(original.t_end, permuted.t_end)
    np.testing.assert_allclose(original.trace, permuted.trace, rtol=1e-9)
    np.testing.assert_allclose(original.path_angle, permuted.path_angle, rtol=0, atol=1e-9)
    np.testing.assert_allclose(original.wheel_load, permuted.wheel_load, rtol=1e-9)
    unrotated = evaluate(
        FilterModel.from_scenario(build_satellite(renamed)), maneuvers.reshape(5, 12)
    )
    assert not np.allclose(unrotated.path_angle, original.path_angle, atol=1e-3)
    assert not np.allclose(unrotated.wheel_load, original.wheel_load, rtol=1e-3)
