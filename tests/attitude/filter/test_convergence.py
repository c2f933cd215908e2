"""When a run counts as converged, equation (6)."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import FilterModel, evaluate
from mgeo_attitude.filter.kernel import count_lanes, load_driver
from mgeo_attitude.filter.reference import has_converged

from ...three import three
from .agreement import assert_agrees

WINDOW, DECREASE = 3, 0.01

#: Three equal maneuvers that end in the Earth's shadow, while the trace rises.
INTO_THE_SHADOW = [0.5, 0.0, 0.0, 1433.0, 0.0, 0.5, 0.0, 1433.0, 0.0, 0.0, 0.5, 1434.0]


@pytest.fixture(scope="module")
def cubesat():
    return FilterModel.from_scenario(three("cubesat_6u"))


@pytest.mark.parametrize(
    ("window", "converged"),
    [
        ([1.0, 1.0, 1.0, 1.0], True),  # did not rise, nor fall
        ([1.0, 0.999, 0.998, 0.995], True),
        ([1.0, 0.999, 0.998, 0.99], False),  # as much as the least decrease
        ([1.0, 0.5, 0.2, 0.1], False),
        ([1.0, 1.0, 1.0, np.nextafter(1.0, 2.0)], False),
        ([1.0, 1.1, 1.2, 1.33], False),
        ([1.0, 2.0, 2.0, 0.995], True),  # only the ends of the window count
        ([1.0, 0.5, 0.5, 1.0], True),
    ],
)
@pytest.mark.parametrize("allow_rise", [False, True])
def test_only_a_trace_that_fell_by_little_has_converged(window, converged, allow_rise):
    expected = converged or (allow_rise and window[-1] > window[0])
    recent = np.zeros((4, count_lanes()))
    recent[:, 1] = np.roll(window, 2)  # a ring, whose last entry is at 1
    assert load_driver().has_converged(recent, 1, 1, WINDOW, DECREASE, allow_rise) == expected
    assert has_converged(window[0], window[-1], DECREASE, allow_rise) == expected


def test_a_run_without_result_ends():
    """Of a covariance that has broken down nothing better is to come."""
    recent = np.full((4, count_lanes()), np.nan)
    assert load_driver().has_converged(recent, 0, 0, WINDOW, DECREASE, False)


def test_a_trace_that_rises_in_eclipse_has_not_converged(cubesat):
    result = evaluate(cubesat, INTO_THE_SHADOW, history=True)
    assert_agrees(cubesat, np.array([INTO_THE_SHADOW]))
    end = round(result.t_end[0])
    trace = result.variances[0, : end + 1] @ cubesat.weights
    assert trace[4300] / trace[4000] == pytest.approx(1.33, abs=0.005)
    assert end > 4300
    before = trace[end - cubesat.window_steps]
    assert (1.0 - cubesat.relative_decrease) * before < trace[end] <= before


def test_a_rise_may_be_allowed(cubesat):
    model = dataclasses.replace(cubesat, allow_rise=True)
    assert evaluate(model, INTO_THE_SHADOW).t_end[0] == 4300.0
    assert_agrees(model, np.array([INTO_THE_SHADOW]))
