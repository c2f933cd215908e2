"""Violations of path constraints by the true attitude, with a controller and in open loop."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import AttitudeManeuverProblem, FilterModel, Scenario
from mgeo_attitude.maneuvers.motion import Motion
from mgeo_attitude.scenario import Convergence, PathConstraint

from ...attitude.geometry.test_rotation import as_scipy
from ..simulators.runs import build_zero_errors, run_filter

STEPS = 300
#: Rates [deg/s] and durations [s] of a plan with rotations by some 100 deg.
PLAN = np.array([0.3, -0.1, 0.2, 80.3, -0.1, 0.3, 0.1, 60.0, 0.2, 0.1, -0.3, 160.0])


def build_scenario(*path_constraints):
    preset = Scenario.cubesat_6u()
    return dataclasses.replace(
        preset,
        maneuvers=dataclasses.replace(preset.maneuvers, count=3),
        duration=float(STEPS),
        eclipse=False,
        convergence=Convergence(window=float(STEPS)),
        path_constraints=path_constraints,
    )


def build_sun_constraint(off_deg, half_angle_deg, **margin):
    """Return a constraint whose axis has the given angle from the Sun at the start, where body axes
    are GCRS axes.
    """
    sun = AttitudeManeuverProblem(build_scenario()).environment.sun[0]
    across = np.cross(sun, [0.0, 0.0, 1.0])
    angle = np.radians(off_deg)
    axis = np.cos(angle) * sun + np.sin(angle) * across / np.linalg.norm(across)
    return PathConstraint(boresight=tuple(axis), half_angle_deg=half_angle_deg, **margin)


@pytest.mark.slow
def test_violated_fractions_follow_from_true_attitude():
    """Without measurements, the estimation errors before and after a sample are equal."""
    constraints = tuple(
        build_sun_constraint(off, half) for off, half in ((12.0, 10.0), (40.0, 35.0), (5.0, 30.0))
    )
    constraints += (build_sun_constraint(12.0, 31.0, sense="keep-in"),)
    constraints += (
        PathConstraint(reference="earth", boresight=(1.0, 0.3, 0.0), half_angle_deg=10.0),
    )
    model = FilterModel.from_scenario(build_scenario(*constraints))
    blind = dataclasses.replace(model, available=np.zeros_like(model.available))
    draws = build_zero_errors(blind, STEPS)
    draws.initial_errors[:6] = [0.1, -0.15, 0.05, 1e-3, -5e-4, 8e-4]  # attitude and gyro bias
    statistics = run_filter(blind, PLAN, np.arange(STEPS + 1), draws, n_watched=200)

    planned_attitude = Motion.from_design(blind, PLAN, STEPS).attitude[:200]
    errors = np.array([as_scipy(-e[:3]).as_matrix() for e in statistics.errors[0, :200]])
    start = as_scipy(-draws.initial_errors[:3]).as_matrix()
    environment = AttitudeManeuverProblem(build_scenario()).environment
    position = environment.position[:200]
    distance = np.linalg.norm(position, axis=1)
    limb = np.degrees(np.arcsin(6378136.3 / distance))
    for fractions, attitude in zip(
        statistics.violated_fractions[0],
        (errors @ planned_attitude, planned_attitude @ start),
        strict=True,
    ):
        sun, nadir = (
            np.einsum("kij,kj->ki", attitude, vectors)
            for vectors in (environment.sun[:200], -position / distance[:, None])
        )
        angles = [
            np.degrees(np.arccos(sun @ constraint.build_cone().axis))
            for constraint in constraints[:4]
        ]
        angles.append(np.degrees(np.arccos(nadir @ constraints[4].build_cone().axis)) - limb)
        inside = [
            angle < constraint.half_angle_deg
            for angle, constraint in zip(angles, constraints, strict=True)
        ]
        expected = [
            ~k if constraint.keep_in else k
            for k, constraint in zip(inside, constraints, strict=True)
        ]
        assert (200 * fractions).tolist() == pytest.approx(np.sum(expected, axis=1), abs=1e-9)
    assert (statistics.violated_fractions[0, 0] != statistics.violated_fractions[0, 1]).any()
    assert (statistics.violated_fractions > 0).any(axis=(0, 1)).sum() >= 4
    assert (statistics.violated_fractions < 1).all(axis=(0, 1)).sum() >= 4
