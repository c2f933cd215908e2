"""Source compiled for several lanes, compared with its execution as plain Python."""

from math import sqrt

import numpy as np
import pytest
from mgeo_attitude.filter.lanewise import lanewise
from numba import njit

TEXT = """
t1 = W[0] * W[1] + W[5] - W[9]
W[2] = -t1 / (W[1] - 2.5)
t1 = sqrt(W[2] * W[2] + 1.0) * (1.0 if W[0] >= W[6] else 0.0)
W[3] = t1 + W[2]
W[0] = 0.25 * W[7]
"""
LOOPS = """
t1 = W[0] * W[1]
for i in range(1, 4, 1):
    t2 = W[i * (i + 1) // 2 + 1] - t1
    for j in range(i + 1, i * 2 + 3, 2):
        t3 = t2 * W[i * 4 + j if 2 >= i else j + 1]
        W[j + 5 + 1] = t3 + W[j + 2]
    W[i] = t2 * W[(i) * 3]
for i in range(3, 3, 1):
    W[i] = 7.0
W[4] = t1
"""


def on_pointer(text, lanes):
    function = lanewise(text, lanes)

    @njit("void(CPointer(float64))")
    def on_pointer(W):
        function(W)

    return on_pointer


def compiled(text, lanes):
    call = on_pointer(text, lanes)

    @njit
    def run(W):
        call(W.ctypes)

    return run


@pytest.mark.parametrize("text", [TEXT, LOOPS])
def test_each_lane_executes_the_source(text):
    lanes = 8
    W = np.random.default_rng(0).standard_normal((16, lanes))
    W[0, 0] = W[6, 0]  # The comparison includes equality.
    expected = W.copy()
    for lane in range(lanes):
        values = expected[:, lane].tolist()
        exec(text, {"sqrt": sqrt, "W": values})
        expected[:, lane] = values
    compiled(text, lanes)(W.reshape(-1))
    np.testing.assert_allclose(W, expected, rtol=1e-15)


def test_root_of_negative_number_is_nan():
    W = np.array([-1.0, 4.0, np.nan, 7.0])
    text = "W[0] = sqrt(W[0])\nW[1] = W[1] - W[1]"
    compiled(text, 2)(W)
    np.testing.assert_array_equal(W, [np.nan, 2.0, np.nan, 0.0])


@pytest.mark.parametrize(
    "text",
    [
        "W[0] = x",
        "W[0] = exp(W[0])",
        "W[i] = 1.0",
        # A name cannot be carried over iterations.
        "t1 = W[0]\nfor i in range(0, 3, 1):\n    t1 = t1 * W[i]",
        "for i in range(0, 3, 1):\n    t1 = W[i]\nW[0] = t1",
        "for i in range(3, 0, -1):\n    W[i] = 1.0",
    ],
)
def test_unsupported_source_is_rejected(text):
    with pytest.raises(ValueError, match="expected"):
        compiled(text, 2)
