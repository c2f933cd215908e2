"""Flights of the independent simulation with faults: each is right or its cause is named."""

import pytest

from . import faulty_flights


@pytest.mark.slow
def test_faults_of_independent_flights_are_named_or_estimated():
    """One flight of every sixth kind of fault; the module runs as many as wanted."""
    results = faulty_flights.campaign(range(4, len(faulty_flights.KINDS), 6))
    assert {result.outcome for result in results} <= {"right", "named"}, results


@pytest.mark.cases(2)
@pytest.mark.parametrize("number", [813, 923, 1450])
def test_fault_that_resembles_another_is_named(number):
    """A field in µT resembles times in ms, point samples a spin, and minutes another orbit."""
    assert faulty_flights.run_case(number).outcome == "named"
