"""Rows that better plans take, and room between them."""

import numpy as np
import pytest
from mgeo_attitude.refine.front import RefinementFront


def judge(X):
    """Two numbers as time and value; a third is a violation."""
    return X[:, :2].copy(), np.maximum(X[:, 2], 0.0)


GIVEN = np.array([[100.0, 8.0, 0.0], [200.0, 4.0, 0.0], [150.0, 9.0, 0.0], [120.0, 1.0, 0.5]])


def test_there_is_room_between_the_plans_of_a_front_alone():
    front = RefinementFront(judge, GIVEN, max_time_ratio=1.2)
    added = front.times[4:]
    # the third is dominated, the fourth breaks a limit
    np.testing.assert_allclose(added, 100.0 * 2.0 ** (np.arange(1, 4) / 4))
    np.testing.assert_array_equal(front.plans, GIVEN)
    assert len(RefinementFront(judge, GIVEN).times) == 4


def test_rows_are_closer_where_values_fall_by_more():
    steep = [np.array([GIVEN[0], GIVEN[1] * [1.0, share, 1.0]]) for share in (1.0, 0.5, 1e-9)]
    rows = [len(RefinementFront(judge, plans, max_time_ratio=1.2).times) - 2 for plans in steep]
    # ratios of 2 in time and in value, of 4, and at most three times as close
    assert rows == [int(by * np.log(2.0) / np.log(1.2)) for by in (1.0, 2.0, 3.0)]


def test_what_is_added_is_better_than_all_plans_before_it():
    front = RefinementFront(judge, GIVEN, max_time_ratio=1.2)
    t = front.times[5]
    front.replace_rows(np.array([[t, 8.5, 0.0], [t, 3.0, 0.1], [0.9 * t, 3.0, 0.0]]))
    np.testing.assert_array_equal(front.plans[:2], GIVEN[:2])
    assert front.rows.tolist() == [0, 1, 2, 3]
    front = RefinementFront(judge, GIVEN, max_time_ratio=1.2)
    better = np.array([[0.99 * t, 5.0, 0.0]])
    front.replace_rows(better)
    assert front.rows.tolist() == [0, 1, 2, 3, 5]
    np.testing.assert_array_equal(front.plans[4], better[0])


def test_at_the_end_none_stays_that_ends_later_and_knows_less():
    front = RefinementFront(judge, GIVEN, max_time_ratio=1.2)
    front.replace_rows(np.array([[99.0, 1.5, 0.0]]))
    np.testing.assert_array_equal(front.plans[1], GIVEN[1])
    front.replace_dominated()
    np.testing.assert_array_equal(front.plans[1], [99.0, 1.5, 0.0])
    assert (front.plans[:, 1] == 1.5).all()


@pytest.mark.parametrize("n", [0, 1])
def test_few_plans_have_no_room_between_them(n):
    assert len(RefinementFront(judge, GIVEN[:n], max_time_ratio=1.2).times) == n
