"""An error budget beside what each source causes alone, carried forward by dense matrices."""

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
CHOSEN = ("paper", "star tracker", "full gyro", "varying errors", "considered")


@pytest.fixture(scope="module", params=[name for name in CHOSEN if name in SUITES])
def model(request):
    suite = SUITES[request.param]
    scenario = dataclasses.replace(
        Scenario.paper(), duration=800.0, step=4.0, gyro=suite.gyro, sensors=suite.sensors
    )
    return FilterModel.from_scenario(scenario).full_duration_model


def alone(model, design, last):
    """Diagonals at the end of every source's own covariance, all with the filter's gains."""
    motion = Motion.from_design(model, design, model.n_steps)
    H, R, seen = build_measurement_model(model, motion.attitude, motion.rates)
    suite, n = model.suite, model.suite.n_states
    counts = [len(sensor.noise_sigmas()) for sensor in suite.sensors]
    rows = np.split(np.arange(sum(counts)), np.cumsum(counts)[:-1])
    density = suite.compute_noise_density()
    driven = [np.isin(np.arange(len(density)) // 3, i) for i in range(len(density) // 3)]
    driven = [own for own in driven if density[own].any()]
    start = model.initial_covariance
    parts = np.zeros((n // 3 + len(driven) + len(rows), n, n))
    for block in range(n // 3):
        own = slice(3 * block, 3 * block + 3)
        parts[block, own, own] = start[own, own]
    total = start
    for k in range(1, last + 1):
        rate = motion.rates[k - 1]
        F, Q = discretize_van_loan(model, rate)
        parts, total = F @ parts @ F.T, F @ total @ F.T + Q
        for i, own in enumerate(driven):
            parts[n // 3 + i] += discretize_van_loan(
                _Driven(model, np.where(own, density, 0.0)), rate
            )[1]
        for i, own in enumerate(rows):
            if not seen[k, own].any():
                continue
            h, r = H[k, own], np.diag(R[own])
            gain = total @ h.T @ np.linalg.inv(h @ total @ h.T + r)
            gain[suite.considered_indices] = 0.0
            rest = np.eye(n) - gain @ h
            parts, total = rest @ parts @ rest.T, rest @ total @ rest.T + gain @ r @ gain.T
            parts[n // 3 + len(driven) + i] += gain @ r @ gain.T
    return np.diagonal(parts, axis1=1, axis2=2)


class _Driven:
    """A model of which but one block is driven by noise, as far as Van Loan asks."""

    def __init__(self, model, density):
        self.step, self.suite, self._suite, self._density = model.step, self, model.suite, density

    def compute_noise_density(self):
        return self._density

    def __getattr__(self, name):
        return getattr(self._suite, name)


@pytest.mark.cases(1)
def test_every_part_is_what_its_source_causes_alone(model):
    found = compute_error_budget(model, DESIGN, END)
    expected = alone(model, DESIGN, round(END / model.step))
    assert found.variances.shape == expected.shape
    whole = expected.sum(axis=0)
    assert np.abs((found.variances - expected) / whole).max() < 1e-9
    assert len(set(found.sources)) == len(found.sources) == len(expected)


@pytest.mark.cases(1)
def test_parts_add_up_to_the_kernels_variances(model):
    known = run_filter(model, DESIGN)
    whole = compute_error_budget(model, DESIGN, known.t_end).variances.sum(axis=0)
    np.testing.assert_allclose(whole, np.diag(known.covariance), rtol=1e-9)
    (at,) = np.flatnonzero(known.times == END)
    whole = compute_error_budget(model, DESIGN, END).variances.sum(axis=0)
    np.testing.assert_allclose(whole, known.sigma[at] ** 2, rtol=1e-9)


def test_correlated_initial_errors_are_one_source():
    paper = FilterModel.from_scenario(
        dataclasses.replace(Scenario.paper(), duration=800.0, step=4.0)
    )
    correlation = np.eye(18)
    correlation[0, 6] = correlation[6, 0] = 0.5
    model = dataclasses.replace(paper, initial_correlation=correlation).full_duration_model
    found = compute_error_budget(model, DESIGN, END)
    known = run_filter(model, DESIGN)
    (at,) = np.flatnonzero(known.times == END)
    assert found.sources[0] == "initial errors, correlated"
    np.testing.assert_allclose(found.variances.sum(axis=0), known.sigma[at] ** 2, rtol=1e-9)
