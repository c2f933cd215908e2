"""Basilisk's coarse Sun sensors as photodiodes on the faces of a cube."""

import numpy as np
import pytest
from mgeo_attitude import Environment, FilterModel, Magnetometer, Photodiode, Scenario
from mgeo_attitude.maneuvers.motion import Motion
from mgeo_calibration.simulators.basilisk.vehicle import Vehicle

from .runs import PLAN, build_errorless_inputs, run_basilisk, short

pytestmark = pytest.mark.basilisk

NORMALS = {"px": (1.0, 0.0, 0.0), "mx": (-1.0, 0.0, 0.0), "py": (0.0, 1.0, 0.0),
           "my": (0.0, -1.0, 0.0), "pz": (0.0, 0.0, 1.0), "mz": (0.0, 0.0, -1.0)}  # fmt: skip


def build_cube(**keys):
    return tuple(Photodiode(name=name, normal=normal, **keys) for name, normal in NORMALS.items())


def test_photodiode_reads_cosine_and_nothing_in_eclipse():
    scenario = short(
        Scenario.paper(),
        60.0,
        sensors=(*build_cube(relative_noise=1e-9), Magnetometer()),
    )
    environment = Environment.from_scenario(scenario)
    model = FilterModel.from_scenario(scenario, environment)
    drawn = build_errorless_inputs(model)
    first = 3 * model.suite.blocks.index("px.sensitivity")
    for k in range(6):
        drawn.true_states[first + 3 * k : first + 3 * k + 3] = [0.03, -0.02, 0.1]
    motion = Motion.from_design(model, PLAN, model.n_steps)
    found = run_basilisk(scenario, motion, drawn, Vehicle.amazonia(), environment)
    sun = np.einsum("kij,kj->ki", found.attitude, environment.sun)
    faces = 0
    for diode, rows in zip(model.suite.sensors[:6], found.sensors, strict=False):
        along = diode.axes[2] + np.array([0.03, -0.02, 0.1]) @ diode.axes
        expected = np.maximum(sun @ along, 0.0)
        np.testing.assert_allclose(rows[1:, 0, 0], expected[1:], rtol=0, atol=1e-8)
        faces += (expected[1:] > 0.1).all()
    assert 1 <= faces < 6
