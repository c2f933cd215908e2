"""Convergence by the rule "trace", equation (6) of docs/explanation/models-and-filter.md."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import FilterModel, evaluate
from mgeo_attitude.filter.kernel import count_lanes, load_driver
from mgeo_attitude.filter.reference import has_converged

from ...three import three
from .agreement import assert_agrees

WINDOW, DECREASE = 3, 0.01

#: Design of three maneuvers that ends in eclipse, while the trace rises.
ECLIPSE_DESIGN = [0.5, 0.0, 0.0, 1433.0, 0.0, 0.5, 0.0, 1433.0, 0.0, 0.0, 0.5, 1434.0]


@pytest.fixture(scope="module")
def cubesat():
    return FilterModel.from_scenario(three("cubesat_6u"))


@pytest.mark.parametrize(
    ("window", "converged"),
    [
        ([1.0, 1.0, 1.0, 1.0], True),  # constant
        ([1.0, 0.999, 0.998, 0.995], True),
        ([1.0, 0.999, 0.998, 0.99], False),  # exactly the required decrease
        ([1.0, 0.5, 0.2, 0.1], False),
        ([1.0, 1.0, 1.0, np.nextafter(1.0, 2.0)], False),
        ([1.0, 1.1, 1.2, 1.33], False),
        ([1.0, 2.0, 2.0, 0.995], True),  # Only the ends of the window matter.
        ([1.0, 0.5, 0.5, 1.0], True),
    ],
)
@pytest.mark.parametrize("allow_rise", [False, True])
def test_trace_with_small_decrease_has_converged(window, converged, allow_rise):
    expected = converged or (allow_rise and window[-1] > window[0])
    recent = np.zeros((4, count_lanes()))
    recent[:, 1] = np.roll(window, 2)  # The last entry of the ring buffer is at index 1.
    assert load_driver().has_converged(recent, 1, 1, WINDOW, DECREASE, allow_rise) == expected
    assert has_converged(window[0], window[-1], DECREASE, allow_rise) == expected


def test_run_with_nan_trace_ends():
    recent = np.full((4, count_lanes()), np.nan)
    assert load_driver().has_converged(recent, 0, 0, WINDOW, DECREASE, False)


def test_trace_that_rises_in_eclipse_has_not_converged(cubesat):
    result = evaluate(cubesat, ECLIPSE_DESIGN, history=True)
    assert_agrees(cubesat, np.array([ECLIPSE_DESIGN]))
    end = round(result.t_end[0])
    trace = result.variances[0, : end + 1] @ cubesat.weights
    assert trace[4300] / trace[4000] == pytest.approx(1.33, abs=0.005)
    assert end > 4300
    before = trace[end - cubesat.window_steps]
    assert (1.0 - cubesat.relative_decrease) * before < trace[end] <= before


def test_allowed_rise_counts_as_convergence(cubesat):
    model = dataclasses.replace(cubesat, allow_rise=True)
    assert evaluate(model, ECLIPSE_DESIGN).t_end[0] == 4300.0
    assert_agrees(model, np.array([ECLIPSE_DESIGN]))
