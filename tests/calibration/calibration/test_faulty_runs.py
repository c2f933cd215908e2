"""Runs of the independent simulator with faults: each is right, or its cause is identified."""

import pytest

from .faulty_runs import KINDS, run_case


@pytest.mark.slow
def test_faults_are_identified_or_estimated():
    """One run of every fourth kind of fault; the module runs any number of cases."""
    results = [run_case(number) for number in range(2, len(KINDS), 4)]
    assert {result.outcome for result in results} <= {"right", "named"}, results


@pytest.mark.cases(1)
@pytest.mark.parametrize(
    ("number", "kind"), [(813, "magnetometer in uT"), (923, "instantaneous rates")]
)
def test_fault_that_resembles_another_is_identified(number, kind):
    """A field in µT resembles times in ms, and instantaneous rates resemble a spin."""
    assert run_case(number, kind).outcome == "named"
