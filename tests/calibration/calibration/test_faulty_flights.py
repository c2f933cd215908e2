"""Flights of the independent simulation with faults: each is right or its cause is named."""

import pytest

from .faulty_flights import KINDS, run_case


@pytest.mark.slow
def test_faults_of_independent_flights_are_named_or_estimated():
    """One flight of every fourth kind of fault; the module runs as many as wanted."""
    results = [run_case(number) for number in range(2, len(KINDS), 4)]
    assert {result.outcome for result in results} <= {"right", "named"}, results


@pytest.mark.cases(1)
@pytest.mark.parametrize(
    ("number", "kind"), [(813, "magnetometer in uT"), (923, "instantaneous rates")]
)
def test_fault_that_resembles_another_is_named(number, kind):
    """A field in µT resembles times in ms, and point samples resemble a spin."""
    assert run_case(number, kind).outcome == "named"
