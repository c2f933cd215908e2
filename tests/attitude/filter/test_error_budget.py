"""Error budget compared with a forward propagation of each error source by dense matrices."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import FilterModel, Scenario, run_filter
from mgeo_attitude.filter.error_budget import compute_error_budget
from mgeo_attitude.filter.history import build_measurement_model
from mgeo_attitude.filter.reference import discretize_van_loan
from mgeo_attitude.maneuvers.motion import Motion

from .suites import SUITES

DESIGN = np.array([0.4, -0.2, 0.1, 300.0, 0.3, 0.5, -0.4, 200.0, -0.6, 0.1, 0.2, 100.0])
END = 700.0
SUITE_NAMES = ("paper", "star tracker", "full gyro", "varying errors", "considered")


@pytest.fixture(scope="module", params=[name for name in SUITE_NAMES if name in SUITES])
def model(request):
    suite = SUITES[request.param]
    scenario = dataclasses.replace(
        Scenario.paper(), duration=800.0, step=4.0, gyro=suite.gyro, sensors=suite.sensors
    )
    return FilterModel.from_scenario(scenario).full_duration_model


def propagate_sources(model, design, last):
    """Return the variances at the end that each source causes with the gains of the filter."""
    motion = Motion.from_design(model, design, model.n_steps)
    H, R, is_measured = build_measurement_model(model, motion.attitude, motion.rates)
    suite, n = model.suite, model.suite.n_states
    counts = [len(sensor.noise_sigmas()) for sensor in suite.sensors]
    rows = np.split(np.arange(sum(counts)), np.cumsum(counts)[:-1])
    density = suite.compute_noise_density()
    driven_blocks = [np.isin(np.arange(len(density)) // 3, i) for i in range(len(density) // 3)]
    driven_blocks = [part for part in driven_blocks if density[part].any()]
    start = model.initial_covariance
    parts = np.zeros((n // 3 + len(driven_blocks) + len(rows), n, n))
    for block in range(n // 3):
        part = slice(3 * block, 3 * block + 3)
        parts[block, part, part] = start[part, part]
    total = start
    for k in range(1, last + 1):
        rate = motion.rates[k - 1]
        F, Q = discretize_van_loan(model, rate)
        parts, total = F @ parts @ F.T, F @ total @ F.T + Q
        for i, part in enumerate(driven_blocks):
            parts[n // 3 + i] += discretize_van_loan(
                _SingleSourceModel(model, np.where(part, density, 0.0)), rate
            )[1]
        for i, part in enumerate(rows):
            if not is_measured[k, part].any():
                continue
            h, r = H[k, part], np.diag(R[part])
            gain = total @ h.T @ np.linalg.inv(h @ total @ h.T + r)
            gain[suite.considered_indices] = 0.0
            error_transition = np.eye(n) - gain @ h
            parts, total = (
                error_transition @ parts @ error_transition.T,
                error_transition @ total @ error_transition.T + gain @ r @ gain.T,
            )
            parts[n // 3 + len(driven_blocks) + i] += gain @ r @ gain.T
    return np.diagonal(parts, axis1=1, axis2=2)


class _SingleSourceModel:
    """Model in which only one block has process noise, with the methods that Van Loan's needs."""

    def __init__(self, model, density):
        self.step, self.suite, self._suite, self._density = model.step, self, model.suite, density

    def compute_noise_density(self):
        return self._density

    def __getattr__(self, name):
        return getattr(self._suite, name)


@pytest.mark.cases(1)
def test_contribution_equals_covariance_of_single_source(model):
    budget = compute_error_budget(model, DESIGN, END)
    expected = propagate_sources(model, DESIGN, round(END / model.step))
    assert budget.variances.shape == expected.shape
    total = expected.sum(axis=0)
    assert np.abs((budget.variances - expected) / total).max() < 1e-9
    assert len(set(budget.sources)) == len(budget.sources) == len(expected)


@pytest.mark.cases(1)
def test_contributions_add_up_to_filter_variances(model):
    history = run_filter(model, DESIGN)
    total = compute_error_budget(model, DESIGN, history.t_end).variances.sum(axis=0)
    np.testing.assert_allclose(total, np.diag(history.covariance), rtol=1e-9)
    (index,) = np.flatnonzero(history.times == END)
    total = compute_error_budget(model, DESIGN, END).variances.sum(axis=0)
    np.testing.assert_allclose(total, history.sigma[index] ** 2, rtol=1e-9)


def test_correlated_initial_errors_are_one_source():
    paper = FilterModel.from_scenario(
        dataclasses.replace(Scenario.paper(), duration=800.0, step=4.0)
    )
    correlation = np.eye(18)
    correlation[0, 6] = correlation[6, 0] = 0.5
    model = dataclasses.replace(paper, initial_correlation=correlation).full_duration_model
    budget = compute_error_budget(model, DESIGN, END)
    history = run_filter(model, DESIGN)
    (index,) = np.flatnonzero(history.times == END)
    assert budget.sources[0] == "initial errors, correlated"
    np.testing.assert_allclose(budget.variances.sum(axis=0), history.sigma[index] ** 2, rtol=1e-9)
