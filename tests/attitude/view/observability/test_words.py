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
            {"sun__misalignment": Z, "mag__misalignment": 1.2 * Z},
            "common rotation of both sensors about body z",
        ),
        (
            {"attitude": Z, "mag__misalignment": Z},
            "common rotation of attitude and mag about body z",
        ),
        ({"sun__misalignment": [0.01, 0.001, 0.0]}, "sun misalignment about body x"),
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


def test_a_star_tracker_and_a_sensor_without_misalignment():
    suite = SUITES["star tracker"]
    common = {"attitude": Z, "tracker__misalignment": Z}
    assert in_words(*direction(suite, **common)) == (
        "common rotation of attitude and tracker about body z"
    )
    every = {**common, "mag__misalignment": Z}
    assert in_words(*direction(suite, **every)) == (
        "common rotation of attitude and both sensors about body z"
    )


def test_three_sensors_and_a_gyro_with_a_misalignment_of_its_own():
    suite = SUITES["two Sun sensors"]
    tilts = {f"{name}__misalignment": Z for name in ("sun_x", "sun_z", "mag")}
    assert in_words(*direction(suite, **tilts)) == "common rotation of all 3 sensors about body z"
    gyro = in_words(*direction(SUITES["full gyro"], gyro__misalignment=0.1 * Z))
    assert gyro == "gyro misalignment about body z"


def test_something_is_always_named():
    """Spread evenly over so many 3-vectors that none has a tenth, the largest is named."""
    suite = SUITES["two Sun sensors"]
    v = np.ones(suite.n_states)
    v[:3] = 1.01
    assert "body" in in_words(suite, suite.initial_sigma(np.radians(5.0)), v)
