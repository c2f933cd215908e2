"""Basilisk simulations for tests, which are skipped if Basilisk is not installed."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import Environment
from mgeo_attitude.scenario import Convergence, Scenario
from mgeo_calibration import calibrate

from ...calibration.runs import check_errors, normalize_error

pytest.importorskip(
    "Basilisk", reason='flights by Basilisk: pip install "./problems/calibration[basilisk]"'
)

from mgeo_calibration.simulators.basilisk.simulation import SimulationInputs, simulate
from mgeo_calibration.simulators.basilisk.telemetry import simulate_telemetry

#: Three maneuvers; the second is shortened because the third starts at a full step.
PLAN = np.array([0.5, 0.3, -0.2, 200.3, -0.3, 0.6, 0.2, 250.0, 0.2, -0.4, 0.7, 300.0])


def short(scenario: Scenario, duration: float, **changes) -> Scenario:
    """Return a scenario that ends early, with three maneuvers."""
    window = Convergence(window=duration)
    changes = {"maneuvers": dataclasses.replace(scenario.maneuvers, count=3)} | changes
    return dataclasses.replace(scenario, duration=duration, convergence=window, **changes)


def build_errorless_inputs(model) -> SimulationInputs:
    """Return simulation inputs without any error."""
    zero, bias = np.zeros(model.suite.n_states), np.zeros((model.n_steps, 3))
    return SimulationInputs(model.initial_attitude, model.initial_rate, zero, zero.copy(), bias)


def check_calibrations(scenario, design, flights, supported=True):
    """Assert that the errors of the calibrations of several runs agree with their covariances, and
    that all are consistent.
    """
    environment, found = Environment.from_scenario(scenario), []
    for seed in range(flights):
        telemetry = simulate_telemetry(scenario, design, seed, environment=environment)
        calibration = calibrate(scenario, telemetry)
        assert calibration.is_consistent or not supported, calibration.conclusion
        found.append(normalize_error(calibration, telemetry))
    check_errors(found, worst=np.inf)
    return telemetry


def run_basilisk(scenario, motion, drawn, vehicle, environment, seed=1):
    """Run Basilisk and return its recorded results."""
    generator = np.random.default_rng(seed)
    return simulate(scenario, motion, drawn, vehicle, environment, generator)
