"""Directions made by hand, and what an engineer would call them."""

import numpy as np
import pytest
from mgeo_attitude.view.observability.covariance import in_words

from ...filter.suites import SUITES

PAPER = SUITES["paper"]


def direction(suite, **vectors):
    """A direction from physical vectors by block, and the initial sigmas it is scaled by."""
    sigma = suite.initial_sigma(np.radians(5.0))
    physical = np.zeros(suite.n_states)
    for block, vector in vectors.items():
        start = 3 * suite.blocks.index(block.replace("__", "."))
        physical[start : start + 3] = vector
    return suite, sigma, physical / sigma


Z = np.array([0.0, 0.0, 0.01])


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize(
    ("vectors", "words"),
    [
        (
            {"attitude": Z, "sun__misalignment": Z, "mag__misalignment": Z},
            "common rotation of attitude and both sensors about body z",
        ),
        (
            {"sun__misalignment": Z, "mag__misalignment": -Z},
            "sun misalignment about body z with mag misalignment about body -z",
        ),
        (
            {"gyro__bias": [0.0, 1e-4, 0.0], "attitude": [0.03, 0.0, 0.0]},
            "gyro bias about body y with attitude about body x",
        ),
        ({"mag__bias": [0.003, 0.0, 0.003]}, "mag bias along body (0.71, 0.00, 0.71)"),
        # 4 % of the square is not worth a word
        ({"sun__bias": [0.02, 0.0, 0.0], "mag__bias": [0.0, 0.008, 0.0]}, "sun bias along body x"),
    ],
)
def test_words(vectors, words, sign):
    signed = {block: sign * np.asarray(vector) for block, vector in vectors.items()}
    assert in_words(*direction(PAPER, **signed)) == words
