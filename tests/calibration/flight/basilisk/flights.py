"""Flights by Basilisk for tests, which are skipped where it is not installed."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import Environment
from mgeo_attitude.scenario import Convergence, Scenario
from mgeo_calibration import calibrate

from ...calibration.flights import check_claimed, normalized

pytest.importorskip(
    "Basilisk", reason='flights by Basilisk: pip install "./problems/calibration[basilisk]"'
)

from mgeo_calibration.simulators.basilisk.simulation import SimulationInputs, simulate
from mgeo_calibration.simulators.basilisk.telemetry import simulate_telemetry

#: Three maneuvers, the second of them cut short by rounding up to a step.
PLAN = np.array([0.5, 0.3, -0.2, 200.3, -0.3, 0.6, 0.2, 250.0, 0.2, -0.4, 0.7, 300.0])


def short(scenario: Scenario, duration: float, **changes) -> Scenario:
    """A scenario that ends early, with three maneuvers."""
    window = Convergence(window=duration)
    changes = {"maneuvers": dataclasses.replace(scenario.maneuvers, count=3)} | changes
    return dataclasses.replace(scenario, duration=duration, convergence=window, **changes)


def errorless(model) -> SimulationInputs:
    """No error at all, of a run of a model."""
    zero, bias = np.zeros(model.suite.n_states), np.zeros((model.n_steps, 3))
    return SimulationInputs(model.initial_attitude, model.initial_rate, zero, zero.copy(), bias)


def check_calibrated(scenario, design, flights, supported=True):
    """Assert that calibrations of so many flights are as good as they claim, and supported."""
    environment, found = Environment.from_scenario(scenario), []
    for seed in range(flights):
        telemetry = simulate_telemetry(scenario, design, seed, environment=environment)
        calibration = calibrate(scenario, telemetry)
        assert calibration.is_consistent or not supported, calibration.conclusion
        found.append(normalized(calibration, telemetry))
    check_claimed(found, worst=np.inf)
    return telemetry


def seen(scenario, motion, drawn, vehicle, environment, seed=1):
    """What Basilisk logs."""
    generator = np.random.default_rng(seed)
    return simulate(scenario, motion, drawn, vehicle, environment, generator)
