"""Simulated runs for tests, without errors or with given errors."""

import numpy as np
from mgeo_attitude.maneuvers.motion import Motion
from mgeo_calibration import FilterSettings
from mgeo_calibration.simulation.simulate import evaluate_filter
from mgeo_calibration.simulators.simulated_run import RandomErrors, simulate_run


def build_zero_errors(model, n_steps):
    """Return the random errors of a run without any error or noise."""
    suite = model.suite
    return RandomErrors(
        np.zeros(suite.n_states),
        np.zeros((n_steps, suite.n_dynamic)),
        np.zeros((n_steps + 1, len(suite.sensors), 3)),
    )


def simulate_motion(model, design, draws):
    """Simulate a run whose true motion is that of a design."""
    return simulate_run(model, Motion.from_design(model, design, len(draws.process_noise)), draws)


def run_filter(model, design, samples, draws, estimator=None, truth=None, n_watched=0):
    """Return the errors and covariances that the filter has at some samples of a simulated run."""
    flight = simulate_motion(truth or model, design, draws)
    return evaluate_filter(
        model, [flight], estimator or FilterSettings(), samples, truth, n_watched
    )
