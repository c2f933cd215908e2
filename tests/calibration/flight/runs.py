"""Single runs for tests: without errors, and with given ones."""

import numpy as np
from mgeo_attitude.maneuvers.motion import Motion
from mgeo_calibration import FilterSettings
from mgeo_calibration.simulation.simulate import evaluate_filter
from mgeo_calibration.simulators.simulated_run import RandomErrors, simulate_run


def none(model, n_steps):
    """A run without any error or noise."""
    suite = model.suite
    return RandomErrors(
        np.zeros(suite.n_states),
        np.zeros((n_steps, suite.n_dynamic)),
        np.zeros((n_steps + 1, len(suite.sensors), 3)),
    )


def flown(model, design, draws):
    """What happens."""
    return simulate_run(model, Motion.from_design(model, design, len(draws.process_noise)), draws)


def estimated(model, design, samples, draws, estimator=None, truth=None, n_watched=0):
    """What is recorded of the run at some samples."""
    flight = flown(truth or model, design, draws)
    return evaluate_filter(
        model, [flight], estimator or FilterSettings(), samples, truth, n_watched
    )
