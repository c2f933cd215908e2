"""What an algorithm looks like when it is printed: the call that makes it."""

import numpy as np
import pytest
from pymoo.constraints.eps import AdaptiveEpsilonConstraintHandling
from pymoo.operators.sampling.lhs import LHS

from mgeo import MGEOCanonical, MGEODirected, MGEOReal, MGEOReal2, MGEOVar


@pytest.mark.parametrize(
    ("algorithm", "text"),
    [
        (MGEOReal(), "MGEOReal()"),
        (MGEOReal(1, 3), "MGEOReal()"),
        (MGEOReal(0.2, perturbation="range"), "MGEOReal(sigma=0.2, perturbation='range')"),
        (MGEOReal(np.array([0.1, 0.5])), "MGEOReal(sigma=[0.1, 0.5])"),
        (MGEOReal(0.5, "a-geo1"), "MGEOReal(sigma=0.5, tau='a-geo1')"),
        (MGEOReal2(n_steps=np.int64(3)), "MGEOReal2(n_steps=3)"),
        (MGEOCanonical(bits=8, restart="random"), "MGEOCanonical(bits=8, restart='random')"),
        (MGEOVar(bits=[2, 3], archive_size=50), "MGEOVar(bits=[2, 3], archive_size=50)"),
        (MGEODirected(difference=(0.2, 0.65)), "MGEODirected()"),
        (MGEODirected(2.0, momentum=(0.1, 0)), "MGEODirected(tau=2.0, momentum=[0.1, 0.0])"),
    ],
)
def test_it_shows_what_is_not_by_default_and_evaluates_to_the_same(algorithm, text):
    assert repr(algorithm) == str(algorithm) == text
    assert repr(eval(text)) == text


def test_what_is_long_or_no_number_is_cut_short():
    algorithm = MGEOReal(np.full(12, 0.1), sampling=np.zeros((30, 12)))
    many, rows = ", ".join(["0.1"] * 6), ", ".join(["[...]"] * 6)
    assert repr(algorithm) == f"MGEOReal(sigma=[{many}, ...], sampling=[{rows}, ...])"
    assert repr(MGEOReal(sampling=LHS())) == "MGEOReal(sampling=LHS(...))"


class Unkept(MGEOReal):
    """Does not keep what it is given, but for what it passes on."""

    def __init__(self, width, depth=1, **options):
        super().__init__(sigma=width / 2, **options)


def test_subclasses_and_wrappers_that_do_not_keep_their_arguments_are_shown_too():
    assert repr(Unkept(0.4, tau=1.0)) == "Unkept(width=..., sigma=0.2, tau=1.0)"
    wrapped = AdaptiveEpsilonConstraintHandling(MGEOReal(0.2))
    assert repr(wrapped) == "AdaptiveEpsilonConstraintHandling(algorithm=...)"
