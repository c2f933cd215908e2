"""The repr of an algorithm is the call that builds it."""

import numpy as np
import pytest

from mgeo import MGEOCanonical, MGEODirected, MGEOReal, MGEOReal2, MGEOVar


@pytest.mark.parametrize(
    ("algorithm", "text"),
    [
        (MGEOReal(), "MGEOReal()"),
        (MGEOReal(0.2, perturbation="range"), "MGEOReal(sigma=0.2, perturbation='range')"),
        (MGEOReal(np.array([0.1, 0.5])), "MGEOReal(sigma=[0.1, 0.5])"),
        (MGEOReal2(n_steps=np.int64(3)), "MGEOReal2(n_steps=3)"),
        (MGEOCanonical(bits=8, restart="random"), "MGEOCanonical(bits=8, restart='random')"),
        (MGEOVar(bits=[2, 3], archive_size=50), "MGEOVar(bits=[2, 3], archive_size=50)"),
        (MGEODirected(2.0, momentum=(0.1, 0)), "MGEODirected(tau=2.0, momentum=[0.1, 0.0])"),
    ],
)
def test_repr_shows_nondefault_parameters_and_evaluates_to_same_algorithm(algorithm, text):
    assert repr(algorithm) == str(algorithm) == text
    assert repr(eval(text)) == text
