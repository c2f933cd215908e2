"""Telemetry in spans, which are formed again, against all of it at once; what a row takes."""

import dataclasses

import numpy as np
import pytest
from mgeo_calibration.calibration.hypotheses import build_hypotheses
from mgeo_calibration.estimation.prior import PriorEstimate
from mgeo_calibration.estimation.residuals import compute_filter_estimates, compute_residuals
from mgeo_calibration.estimation.score import compute_scores
from mgeo_calibration.estimation.smoother import compute_last_covariance, solve_linearized
from mgeo_calibration.estimation.trajectory import Partition

from .flights import options
from .test_smoother import MEMS, covariances, near, scenario, spread


@pytest.fixture
def spans(monkeypatch):
    """Sets how many samples are formed at once; none of them is kept."""

    def of(length):
        monkeypatch.setattr("mgeo_calibration.estimation.trajectory.SPAN_LENGTH", length)
        for each in ("smoother", "trajectory"):
            monkeypatch.setattr(f"mgeo_calibration.estimation.{each}.MAX_SPAN_MEMORY", 0.0)

    return of


def said(of, data, at):
    """All that a solution says, each in its own 1-sigmas or so."""
    belief, parts = PriorEstimate.from_suite(data.suite), Partition.from_suite(data.suite)
    rejected = np.zeros(data.has_reading.shape, dtype=bool)
    rejected[0, [3, 22]] = True
    found = solve_linearized(data, belief, at, parts, rejected)
    d = len(parts.stochastic)
    past, left = compute_filter_estimates(found, d), compute_residuals(found)
    sigma = np.sqrt(np.einsum("nii->ni", covariances(found, spread(found, d))))
    last = compute_last_covariance(found)
    unit = np.sqrt(np.diag(last))
    channel = np.sin(0.3 * data.times)
    asked = build_hypotheses(found, {"temperature": channel})
    tested = compute_scores(found, options(asked))
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
def test_spans_say_what_all_at_once_say(name, gyro, spans):
    """Short ones, of which some are without any reading of a sensor, beside a break."""
    of = scenario(name, **gyro)
    data, at = near(of)
    sensors = [rows.copy() for rows in data.readings]
    sensors[-1][8:20] = np.nan
    data = dataclasses.replace(data, readings=tuple(sensors))
    spans(10**6)
    whole = said(of, data, at)
    for length in (1, 5):
        spans(length)
        parts = said(of, data, at)
        for what, values in whole.items():
            np.testing.assert_allclose(parts[what], values, rtol=1e-9, atol=1e-9, err_msg=what)
