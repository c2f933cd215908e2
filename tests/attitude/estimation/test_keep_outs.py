"""How often the Sun truly is inside a keep-out cone, steered by the estimate and open loop."""

import dataclasses
from math import erfc, sqrt

import numpy as np
import pytest
from mgeo_attitude import AttitudeManeuverProblem, FilterModel, Scenario, simulate
from mgeo_attitude.fields import InvalidValue
from mgeo_attitude.flight import Motion
from mgeo_attitude.scenario import Convergence, KeepOut

from ..flight.runs import estimated, none
from ..flight.test_rotation import as_scipy

STEPS = 300
#: Rates [deg/s] that turn a satellite with GCRS axes through some 100 deg.
PLAN = np.array([0.3, -0.1, 0.2, 80.3, -0.1, 0.3, 0.1, 60.0, 0.2, 0.1, -0.3, 160.0])


def scenario(*keep_outs):
    return dataclasses.replace(
        Scenario.cubesat_6u(),
        duration=float(STEPS),
        eclipse=False,
        convergence=Convergence(window=float(STEPS)),
        keep_outs=keep_outs,
    )


def toward_sun(off_deg, half_angle_deg, **margin):
    """A cone whose axis is so far from the Sun at the start, where body axes are those of GCRS."""
    sun = AttitudeManeuverProblem(scenario()).environment.sun[0]
    across = np.cross(sun, [0.0, 0.0, 1.0])
    off = np.radians(off_deg)
    axis = np.cos(off) * sun + np.sin(off) * across / np.linalg.norm(across)
    return KeepOut(boresight=tuple(axis), half_angle_deg=half_angle_deg, **margin)


def test_counts_are_those_of_the_errors():
    """Blind sensors, so that errors before and after a measurement are the same."""
    cones = tuple(toward_sun(off, half) for off, half in ((12.0, 10.0), (40.0, 35.0), (5.0, 30.0)))
    model = FilterModel.from_scenario(scenario(*cones))
    blind = dataclasses.replace(model, available=np.zeros_like(model.available))
    draws = none(blind, STEPS)
    draws.errors[:6] = [0.1, -0.15, 0.05, 1e-3, -5e-4, 8e-4]  # attitude and gyro bias
    sun = blind.sun[:200]
    record = estimated(blind, PLAN, np.arange(STEPS + 1), draws, cones=cones, sun=sun)

    plan = Motion.of(blind, PLAN, STEPS).attitude[:200]
    errors = np.array([as_scipy(-e[:3]).as_matrix() for e in record.errors[0, :200]])
    start = as_scipy(-draws.errors[:3]).as_matrix()
    for shares, attitude in zip(record.inside[0], (errors @ plan, plan @ start), strict=True):
        seen = np.einsum("kij,kj->ki", attitude, sun)
        expected = [
            (seen @ cone.axis() > np.cos(np.radians(cone.half_angle_deg))).sum() for cone in cones
        ]
        assert (200 * shares).tolist() == pytest.approx(expected, abs=1e-9)
    assert (record.inside[0, 0] != record.inside[0, 1]).any()
    assert (record.inside > 0).any()
    assert (record.inside < 1).any()


def test_no_flight_is_inside_in_the_dark():
    cone = toward_sun(0.0, 80.0)
    day = FilterModel.from_scenario(scenario(cone))
    dark = dataclasses.replace(day, sun=np.zeros_like(day.sun))
    for model, share in ((day, 1), (dark, 0)):
        record = estimated(
            model, PLAN, np.arange(STEPS + 1), none(model, STEPS), cones=(cone,), sun=model.sun[:20]
        )
        assert (record.inside == share).all()


def test_what_passes_a_cone_by_a_degree_is_inside_it_unless_it_keeps_the_margin():
    """10 deg of initial attitude: flights start inside when an error of a degree says so."""
    bare = toward_sun(21.0, 20.0, attitude_sigmas=0.0)
    wide = toward_sun(51.0, 20.0)
    away = np.zeros(12)
    with pytest.raises(InvalidValue, match=r"keep_outs\[1\]\.half_angle_deg = 20\.0.* 21 deg"):
        AttitudeManeuverProblem(scenario(bare, dataclasses.replace(bare, attitude_sigmas=3.0)))
    G = AttitudeManeuverProblem(scenario(bare, wide)).evaluate(away, return_values_of=["G"])
    assert (G < 0.0).all()
    n = 400
    table = simulate(scenario(bare, wide), away, n_runs=n, seed=2).keep_outs()
    beyond = [100.0 * 0.5 * erfc(k / sqrt(2.0)) for k in (0.1, 3.1)]
    for way in ("steered", "open loop"):
        flights = table[f"{way}: flights [%]"].to_numpy()
        chance = 3.0 * np.sqrt(np.multiply(beyond, np.subtract(100.0, beyond)) / n)
        assert abs(flights[0] - beyond[0]) < chance[0] + 5.0  # the error across adds a little
        assert flights[1] <= beyond[1] + chance[1]
    # what is steered leaves the cone when its filter has seen the Sun, the other one never does
    time = table.loc[:, [f"{way}: time [%]" for way in ("steered", "open loop")]].to_numpy()
    assert time[0, 0] < 0.2 * time[0, 1]
    assert time[0, 1] == pytest.approx(table["open loop: flights [%]"].iloc[0], rel=0.05)
