"""Straight-line text compiled for several lanes against the same text run as plain Python."""

from math import sqrt

import numpy as np
import pytest
from mgeo_attitude.filter.lanewise import lanewise
from numba import njit

TEXT = """
t1 = W[0] * W[1] + C[0] - R[2]
W[2] = -t1 / (W[1] - 2.5)
t1 = sqrt(W[2] * W[2] + 1.0) * (1.0 if W[0] >= C[1] else 0.0)
W[3] = t1 + W[2]
W[0] = 0.25 * R[0]
"""


NOTHING, NOWHERE = np.zeros(1), np.zeros(1, dtype=np.int64)


def on_pointers(text, lanes, width=0):
    function = lanewise(text, lanes, width)

    @njit("void(CPointer(float64), CPointer(float64), CPointer(float64), CPointer(int64))")
    def on_pointers(W, C, R, rows):
        function(W, C, R, rows)

    return on_pointers


def compiled(text, lanes, width=0):
    call = on_pointers(text, lanes, width)

    @njit
    def run(W, C, R, rows):
        call(W.ctypes, C.ctypes, R.ctypes, rows.ctypes)

    return run


@pytest.mark.parametrize("lanes", [2, 4, 8])
def test_every_lane_does_what_the_text_says(lanes):
    rng = np.random.default_rng(0)
    W, C = rng.standard_normal((5, lanes)), np.array([0.5, 0.1])
    W[0, 0] = C[1]  # the bound itself is reached
    R, rows = rng.standard_normal((10, 3)), rng.integers(10, size=lanes)
    expected = W.copy()
    for lane in range(lanes):
        values = expected[:, lane].tolist()
        exec(TEXT, {"sqrt": sqrt, "W": values, "C": C.tolist(), "R": R[rows[lane]]})
        expected[:, lane] = values
    compiled(TEXT, lanes, 3)(W.reshape(-1), C, R.reshape(-1), rows)
    np.testing.assert_allclose(W, expected, rtol=1e-15)


def test_broken_arithmetic_shows_as_nan():
    W = np.array([-1.0, 4.0, np.nan, 7.0])
    text = "W[0] = sqrt(W[0])\nW[1] = W[1] - W[1]"
    compiled(text, 2)(W, NOTHING, NOTHING, NOWHERE)
    np.testing.assert_array_equal(W, [np.nan, 2.0, np.nan, 0.0])


@pytest.mark.parametrize(
    "text",
    [
        "W[0] = x",
        "W[0] = W[0] @ W[1]",
        "W[0] += 1.0",
        "C[0] = 1.0",
        "W[0] = exp(W[0])",
        "W[0] = R[2]",
    ],
)
def test_text_of_another_kind_is_refused(text):
    with pytest.raises(ValueError, match="expected"):
        compiled(text, 2, width=2)


@pytest.mark.parametrize("lanes", [4, 8])
def test_the_stack_is_aligned_to_vectors(lanes):
    (ir,) = on_pointers("W[0] = W[1]", lanes).inspect_llvm().values()
    assert f"alignstack={8 * lanes}" in ir
