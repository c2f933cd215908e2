"""Thousands of cases of bad input; `python -m tests.campaign` makes more, and any of them again."""

import pytest

from . import kinds
from .__main__ import campaign
from .harness import run_case

BLOCKS, CASES = 10, 500


@pytest.mark.slow
@pytest.mark.parametrize("block", range(BLOCKS))
def test_bad_input_is_refused_and_damages_nothing(block):
    failed = campaign(range(block * CASES, (block + 1) * CASES))
    shown = [f"python -m tests.campaign --case {r.number}: {r.failures[0]}" for r in failed]
    assert shown == []


def test_a_case_does_the_same_again():
    for number in range(40):
        one, two = run_case(number), run_case(number)
        assert (one.kind, one.log, one.refused) == (two.kind, two.log, two.refused)


def test_most_cases_are_refused_and_sound_ones_are_not():
    made = [run_case(number, "run read") for number in range(60)]
    assert sum(result.refused for result in made) > 30
    assert not any(run_case(n, "sound command").refused for n in range(4))


@pytest.mark.parametrize("name", sorted(kinds.KINDS))
def test_every_kind_makes_cases(name):
    assert run_case(1, name).failures == []
