"""What the papers' names and decimal commas are answered with: one line that says what to type."""

import re

import pytest

from mgeo import MGEOReal
from mgeo.validation.arguments import decimal_point

STUDY = """
title = "t"
evaluations = 60
seeds = 1
[[problems]]
name = "pymoo:zdt1"
[[algorithms]]
name = "mgeo-real"
"""


@pytest.mark.parametrize(
    ("flags", "said"),
    [
        ("--n-i 30", "n_i of the papers is --walkers"),
        ("--n_i 30", "n_i of the papers is --walkers"),
        ("--set n_i=30", "n_i of the papers is --walkers"),
        ("--sigma 0,5", "expected a number; the decimal separator is a point: 0.5"),
        ("--sigma 1,5", "expected one number, .*; the decimal separator is a point: 1.5"),
        ("--tau 3,5", "the decimal separator is a point: 3.5"),
        ("--evaluations 1,5", "the decimal separator is a point: 1.5"),
    ],
)
def test_what_a_run_is_refused_with(mgeo, flags, said):
    done = mgeo("solve", "pymoo:zdt1", "--algorithm", "mgeo-real", "--dry-run", *flags.split())
    assert done.exit_code == 2
    assert done.stderr.count("\n") == 1
    assert re.search(said, done.stderr), done.stderr


def test_what_files_are_refused_with(mgeo, tmp_path):
    path = tmp_path / "study.toml"
    for line, said in (
        ("n_i = 30", "has no parameter 'n_i': .*; n_i of the papers is n_walkers"),
        ("sigma = 0,5 # half", "no valid TOML: .*; the decimal separator is a point: 0.5"),
    ):
        path.write_text(f"{STUDY}{line}\n")
        done = mgeo("study", path, "--dry-run")
        assert done.exit_code == 2
        assert done.stderr.count("\n") == 1
        assert re.search(said, done.stderr), done.stderr


def test_lists_of_numbers_are_no_decimal_commas(mgeo):
    assert decimal_point("0.5", "1,2,3", "a,b", "1, 2") == ""
    assert decimal_point("12,25") == "; the decimal separator is a point: 12.25"
    two = "pymoo:bnh"  # of two variables
    done = mgeo("solve", two, "--algorithm", "mgeo-real", "--sigma", "1,2", "--dry-run", "-q")
    assert done.exit_code == 0, done.stderr


def test_the_constructor_says_it_too():
    with pytest.raises(TypeError, match="'n_i': n_walkers is the n_i of the papers"):
        MGEOReal(n_i=30)
