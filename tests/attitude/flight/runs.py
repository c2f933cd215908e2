"""Single runs for tests: without errors, and with given ones."""

import numpy as np
from mgeo_attitude import Estimator
from mgeo_attitude.estimation.record import record
from mgeo_attitude.flight import Draws, Motion, fly_runs


def none(model, n_steps, n_runs=1):
    """Runs without any error or noise."""
    suite = model.suite
    return Draws(
        np.zeros((n_runs, suite.n_states)),
        np.zeros((n_steps, n_runs, suite.n_dynamic)),
        np.zeros((n_steps + 1, n_runs, len(suite.sensors), 3)),
    )


def fly(model, design, draws):
    """What happens."""
    return fly_runs(model, Motion.of(model, design, len(draws.gyro_noise)), draws)


def estimated(model, design, samples, draws, estimator=None, truth=None, cones=(), sun=()):
    """What is recorded of the runs at some samples."""
    flight = fly(truth or model, design, draws)
    return record(model, flight, estimator or Estimator(), samples, cones, sun)
