"""Allocation of torque to wheels, against linear programs and least squares."""

import numpy as np
import pytest
from mgeo_attitude.scenario.actuators import (
    ALLOCATIONS,
    minimax_allocation,
    pseudo_inverse_allocation,
)
from scipy.optimize import linprog

PYRAMID = np.array([[1.0, 0.0, 1.0], [-1.0, 0.0, 1.0], [0.0, 1.0, 1.0], [0.0, -1.0, 1.0]])
ARRAYS = {
    "body axes": np.eye(3),
    "tilted three": np.array([[1.0, 0.2, 0.0], [0.0, 1.0, -0.4], [0.3, 0.0, 1.0]]),
    "pyramid": PYRAMID,
    "body axes and a skew axis": np.vstack([np.eye(3), np.ones(3)]),
    "two along one axis": np.array([[1.0, 0, 0], [1.0, 0, 0], [0, 1.0, 0], [0, 0, 1.0]]),
    "six": np.random.default_rng(3).standard_normal((6, 3)),
}


@pytest.fixture(params=ARRAYS, name="axes")
def axes_(request):
    axes = ARRAYS[request.param]
    return axes / np.linalg.norm(axes, axis=1, keepdims=True)


def draw_demands(n=10):
    return np.random.default_rng(1).standard_normal((n, 3))


def test_minimax_load_equals_linear_program(axes):
    """The program minimizes t subject to A u = m and -t <= u <= t."""
    n = len(axes)
    bounds = np.block([[np.eye(n), -np.ones((n, 1))], [-np.eye(n), -np.ones((n, 1))]])
    for m in draw_demands():
        program = linprog(
            np.append(np.zeros(n), 1.0),
            A_ub=bounds,
            b_ub=np.zeros(2 * n),
            A_eq=np.column_stack([axes.T, np.zeros(3)]),
            b_eq=m,
            bounds=[(None, None)] * n + [(0.0, None)],
        )
        assert np.abs(minimax_allocation(axes) @ m).max() == pytest.approx(program.fun, rel=1e-9)


def test_pseudo_inverse_equals_least_squares(axes):
    for m in draw_demands():
        u = np.linalg.lstsq(axes.T, m, rcond=None)[0]
        np.testing.assert_allclose(pseudo_inverse_allocation(axes) @ m, u, rtol=0, atol=1e-12)


def test_allocation_rules_are_equal_for_three_independent_axes(axes):
    loads = {
        rule: np.abs(draw_demands() @ allocate(axes).T).max(axis=1)
        for rule, allocate in ALLOCATIONS.items()
    }
    # Two wheels along one axis have equal loads with both rules.
    if len(axes) == 3 or len(np.unique(axes, axis=0)) == 3:
        np.testing.assert_allclose(loads["minimax"], loads["pseudo-inverse"], rtol=1e-12)
    else:
        assert (loads["minimax"] <= loads["pseudo-inverse"] * (1.0 + 1e-12)).all()
        assert (loads["minimax"] < 0.99 * loads["pseudo-inverse"]).any()
