"""Thousands of cases of bad input; `python -m tests.campaign` makes more, and any of them again."""

import pytest

from . import faulty_flights, kinds
from .__main__ import campaign
from .harness import run_case

FILES, COMMANDS = 2350, 150  # cases that only read a file, and of all kinds
FLIGHTS = 800  # of telemetry


@pytest.mark.cases(0, 1)
@pytest.mark.parametrize("block", range(5))
def test_bad_files_are_refused(block):
    size = FILES // 5
    assert _failures(campaign(range(block * size, (block + 1) * size), kinds.CHEAP)) == []


@pytest.mark.cases(0, 1)
@pytest.mark.parametrize("block", range(3))
def test_bad_input_of_all_kinds_is_refused_and_damages_nothing(block):
    size = COMMANDS // 3
    assert _failures(campaign(range(block * size, (block + 1) * size))) == []


@pytest.mark.cases(0, 1)
@pytest.mark.parametrize("block", range(32))
def test_bad_telemetry_is_refused_and_damages_nothing(block):
    size = FLIGHTS // 32
    assert _failures(campaign(range(block * size, (block + 1) * size), kinds.TELEMETRY)) == []


@pytest.mark.slow
def test_faults_of_flights_are_named():
    """Of every sixth kind one; `python -m tests.campaign.faulty_flights` makes as many as asked."""
    results = faulty_flights.campaign(range(4, len(faulty_flights.KINDS), 6))
    assert {result.outcome for result in results} <= {"right", "named"}, results


def _failures(failed):
    return [f"case {result.number} ({result.kind}): {result.failures[0]}" for result in failed]


@pytest.mark.slow
def test_a_case_does_the_same_again():
    for number in range(6):
        one, two = run_case(number), run_case(number)
        assert (one.kind, one.log, one.refused) == (two.kind, two.log, two.refused)


@pytest.mark.slow
def test_most_cases_are_refused_and_sound_ones_are_not():
    made = [run_case(number, ["run read"]) for number in range(40)]
    assert sum(result.refused for result in made) > 20
    assert not any(run_case(n, ["sound command"]).refused for n in range(4))


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(kinds.KINDS))
def test_every_kind_makes_cases(name):
    assert run_case(1, [name]).failures == []


@pytest.mark.cases(2, 3)
@pytest.mark.parametrize("number", [813, 923, 1450, 653, 240, 347, 532])
def test_cases_that_were_told_wrong_or_not_at_all(number):
    """A field in uT was times in milliseconds; rates at the samples of a spin passed.

    Minutes and local time, where field strengths fit as well, were rates in rad/s and another place
    on the orbit; a place on the orbit was other axes, or local time where a bias is far larger than
    believed.
    """
    assert faulty_flights.run_case(number).outcome == "named"
