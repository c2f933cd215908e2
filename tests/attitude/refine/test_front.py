"""Replacement of plans in a front during refinement, and end times between the plans."""

import numpy as np
import pytest
from mgeo_attitude.refine.front import RefinementFront


def evaluate_designs(X):
    """Return the first two variables as time and objective, and the third one as violation."""
    return X[:, :2].copy(), np.maximum(X[:, 2], 0.0)


INITIAL = np.array([[100.0, 8.0, 0.0], [200.0, 4.0, 0.0], [150.0, 9.0, 0.0], [120.0, 1.0, 0.5]])


def test_end_times_are_added_between_nondominated_plans():
    front = RefinementFront(evaluate_designs, INITIAL, max_time_ratio=1.2)
    added = front.times[4:]
    # The third plan is dominated, and the fourth violates a constraint.
    np.testing.assert_allclose(added, 100.0 * 2.0 ** (np.arange(1, 4) / 4))
    np.testing.assert_array_equal(front.plans, INITIAL)
    assert len(RefinementFront(evaluate_designs, INITIAL).times) == 4


def test_added_times_are_denser_where_objective_falls_faster():
    fronts = [np.array([INITIAL[0], INITIAL[1] * [1.0, share, 1.0]]) for share in (1.0, 0.5, 1e-9)]
    counts = [
        len(RefinementFront(evaluate_designs, plans, max_time_ratio=1.2).times) - 2
        for plans in fronts
    ]
    # The objective falls by a factor of 2, 4 and 2e9; the density increases at most threefold.
    assert counts == [int(by * np.log(2.0) / np.log(1.2)) for by in (1.0, 2.0, 3.0)]


def test_added_plans_improve_on_all_earlier_plans():
    front = RefinementFront(evaluate_designs, INITIAL, max_time_ratio=1.2)
    t = front.times[5]
    front.store_improvements(np.array([[t, 8.5, 0.0], [t, 3.0, 0.1], [0.9 * t, 3.0, 0.0]]))
    np.testing.assert_array_equal(front.plans[:2], INITIAL[:2])
    assert front.rows.tolist() == [0, 1, 2, 3]
    front = RefinementFront(evaluate_designs, INITIAL, max_time_ratio=1.2)
    better = np.array([[0.99 * t, 5.0, 0.0]])
    front.store_improvements(better)
    assert front.rows.tolist() == [0, 1, 2, 3, 5]
    np.testing.assert_array_equal(front.plans[4], better[0])


def test_dominated_plans_are_replaced():
    front = RefinementFront(evaluate_designs, INITIAL, max_time_ratio=1.2)
    front.store_improvements(np.array([[99.0, 1.5, 0.0]]))
    np.testing.assert_array_equal(front.plans[1], INITIAL[1])
    front.replace_dominated()
    np.testing.assert_array_equal(front.plans[1], [99.0, 1.5, 0.0])
    assert (front.plans[:, 1] == 1.5).all()


@pytest.mark.parametrize("n", [0, 1])
def test_no_times_are_added_for_fewer_than_two_plans(n):
    assert len(RefinementFront(evaluate_designs, INITIAL[:n], max_time_ratio=1.2).times) == n
