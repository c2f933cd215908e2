"""How often path limits truly are broken, steered by the estimate and open loop."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import AttitudeManeuverProblem, FilterModel, Scenario
from mgeo_attitude.maneuvers.motion import Motion
from mgeo_attitude.scenario import Convergence, PathConstraint

from ...attitude.geometry.test_rotation import as_scipy
from ..simulators.runs import build_zero_errors, run_filter

STEPS = 300
#: Rates [deg/s] that turn a satellite with GCRS axes through some 100 deg.
PLAN = np.array([0.3, -0.1, 0.2, 80.3, -0.1, 0.3, 0.1, 60.0, 0.2, 0.1, -0.3, 160.0])


def scenario(*path_constraints):
    preset = Scenario.cubesat_6u()
    return dataclasses.replace(
        preset,
        maneuvers=dataclasses.replace(preset.maneuvers, count=3),
        duration=float(STEPS),
        eclipse=False,
        convergence=Convergence(window=float(STEPS)),
        path_constraints=path_constraints,
    )


def toward_sun(off_deg, half_angle_deg, **margin):
    """A cone whose axis is so far from the Sun at the start, where body axes are those of GCRS."""
    sun = AttitudeManeuverProblem(scenario()).environment.sun[0]
    across = np.cross(sun, [0.0, 0.0, 1.0])
    off = np.radians(off_deg)
    axis = np.cos(off) * sun + np.sin(off) * across / np.linalg.norm(across)
    return PathConstraint(boresight=tuple(axis), half_angle_deg=half_angle_deg, **margin)


@pytest.mark.slow
def test_counts_are_those_of_the_errors():
    """Blind sensors, so that errors before and after a measurement are the same."""
    cones = tuple(toward_sun(off, half) for off, half in ((12.0, 10.0), (40.0, 35.0), (5.0, 30.0)))
    cones += (toward_sun(12.0, 31.0, sense="keep-in"),)
    cones += (PathConstraint(reference="earth", boresight=(1.0, 0.3, 0.0), half_angle_deg=10.0),)
    model = FilterModel.from_scenario(scenario(*cones))
    blind = dataclasses.replace(model, available=np.zeros_like(model.available))
    draws = build_zero_errors(blind, STEPS)
    draws.initial_errors[:6] = [0.1, -0.15, 0.05, 1e-3, -5e-4, 8e-4]  # attitude and gyro bias
    record = run_filter(blind, PLAN, np.arange(STEPS + 1), draws, n_watched=200)

    plan = Motion.from_design(blind, PLAN, STEPS).attitude[:200]
    errors = np.array([as_scipy(-e[:3]).as_matrix() for e in record.errors[0, :200]])
    start = as_scipy(-draws.initial_errors[:3]).as_matrix()
    environment = AttitudeManeuverProblem(scenario()).environment
    position = environment.position[:200]
    distance = np.linalg.norm(position, axis=1)
    limb = np.degrees(np.arcsin(6378136.3 / distance))
    for shares, attitude in zip(
        record.violated_fractions[0], (errors @ plan, plan @ start), strict=True
    ):
        sun, nadir = (
            np.einsum("kij,kj->ki", attitude, vectors)
            for vectors in (environment.sun[:200], -position / distance[:, None])
        )
        angles = [np.degrees(np.arccos(sun @ cone.build_cone().axis)) for cone in cones[:4]]
        angles.append(np.degrees(np.arccos(nadir @ cones[4].build_cone().axis)) - limb)
        inside = [angle < cone.half_angle_deg for angle, cone in zip(angles, cones, strict=True)]
        expected = [~k if cone.keep_in else k for k, cone in zip(inside, cones, strict=True)]
        assert (200 * shares).tolist() == pytest.approx(np.sum(expected, axis=1), abs=1e-9)
    assert (record.violated_fractions[0, 0] != record.violated_fractions[0, 1]).any()
    assert (record.violated_fractions > 0).any(axis=(0, 1)).sum() >= 4
    assert (record.violated_fractions < 1).all(axis=(0, 1)).sum() >= 4
