"""Telemetry in spans, which are linearized again when needed, against a single batch; memory per
sample.
"""

import dataclasses

import numpy as np
import pytest
from mgeo_calibration.calibration.hypotheses import build_hypotheses
from mgeo_calibration.estimation.prior import PriorEstimate
from mgeo_calibration.estimation.residuals import compute_filter_estimates, compute_residuals
from mgeo_calibration.estimation.score import compute_scores
from mgeo_calibration.estimation.smoother import compute_last_covariance, solve_linearized
from mgeo_calibration.estimation.trajectory import Partition

from .runs import list_model_errors
from .test_smoother import (
    MEMS,
    build_batch_near_truth,
    build_scenario,
    collect_covariances,
    compute_covariances,
)


@pytest.fixture
def spans(monkeypatch):
    """Return a function that sets the number of samples per span; no span stays in memory."""

    def of(length):
        monkeypatch.setattr("mgeo_calibration.estimation.trajectory.SPAN_LENGTH", length)
        for each in ("smoother", "trajectory"):
            monkeypatch.setattr(f"mgeo_calibration.estimation.{each}.MAX_SPAN_MEMORY", 0.0)

    return of


def collect_results(of, data, at):
    """Return all results of a solution, scaled by their 1-sigmas."""
    belief, parts = PriorEstimate.from_suite(data.suite), Partition.from_suite(data.suite)
    rejected = np.zeros(data.has_reading.shape, dtype=bool)
    rejected[0, [3, 22]] = True
    found = solve_linearized(data, belief, at, parts, rejected)
    d = len(parts.stochastic)
    past, left = compute_filter_estimates(found, d), compute_residuals(found)
    sigma = np.sqrt(np.einsum("nii->ni", compute_covariances(found, collect_covariances(found, d))))
    last = compute_last_covariance(found)
    unit = np.sqrt(np.diag(last))
    channel = np.sin(0.3 * data.times)
    asked = build_hypotheses(found, {"temperature": channel})
    tested = compute_scores(found, list_model_errors(asked))
    scale = np.sqrt(np.diag(tested.information)) + 1e-6
    return {
        "cost": found.cost / found.cost,
        "e": found.stochastic_errors / sigma,
        "e_c": found.constant_errors / np.sqrt(np.diag(found.constants_covariance)),
        "last": last / np.outer(unit, unit),
        "residuals": left.values / data.noise[:, None],
        "squares": np.nan_to_num(left.normalized_squares),
        "past": past.errors / sigma.mean(axis=0),
        "until": past.covariances / np.outer(*[sigma.mean(axis=0)] * 2),
        **{f"whitened {k}": each.whitened_values for k, each in enumerate(past.innovations)},
        "information": tested.information / np.outer(scale, scale),
        "score": tested.gradient / scale,
    }


@pytest.mark.cases(1)
@pytest.mark.parametrize(
    ("name", "gyro"),
    [
        ("paper", MEMS),
        ("varying errors", MEMS),
    ],
)
def test_spans_agree_with_single_batch(name, gyro, spans):
    """Short spans, some without readings of a sensor, next to a break."""
    of = build_scenario(name, **gyro)
    data, at = build_batch_near_truth(of)
    sensors = [rows.copy() for rows in data.readings]
    sensors[-1][8:20] = np.nan
    data = dataclasses.replace(data, readings=tuple(sensors))
    spans(10**6)
    whole = collect_results(of, data, at)
    for length in (1, 5):
        spans(length)
        parts = collect_results(of, data, at)
        for what, values in whole.items():
            np.testing.assert_allclose(parts[what], values, rtol=1e-9, atol=1e-9, err_msg=what)
