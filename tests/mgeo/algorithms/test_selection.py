import math

import numpy as np
import pytest
from scipy.stats import chi2_contingency, chisquare

from mgeo.algorithms.selection import draw_position, rank

from .. import naive

DRAWS = 200_000


@pytest.mark.parametrize("tau", [0.0, 0.5, 1.0, 3.0])
@pytest.mark.parametrize("n", [1, 2, 12])
def test_drawn_positions_follow_power_law(n, tau):
    places = draw_position(np.random.default_rng(0).random(DRAWS), n, tau)
    law = np.array([k**-tau for k in range(1, n + 1)])
    counts = np.bincount(places, minlength=n)
    assert len(counts) == n
    if n > 1:
        assert chisquare(counts, DRAWS * law / law.sum()).pvalue > 1e-3


@pytest.mark.parametrize("tau", [0.5, 3.0])
def test_drawn_positions_agree_with_rejection_sampling(tau):
    rng = np.random.default_rng(1)
    rejected = np.bincount([naive.rejection_rank(rng, 6, tau) - 1 for _ in range(40_000)])
    picked = np.bincount(draw_position(rng.random(40_000), 6, tau))
    assert chi2_contingency([rejected, picked]).pvalue > 1e-3


def test_drawn_positions_stay_in_range_for_extreme_random_numbers():
    ends = np.array([0.0, np.nextafter(1.0, 0.0)])
    assert draw_position(ends, 12, 0.0).tolist() == [0, 11]
    assert draw_position(ends, 1, 3.0).tolist() == [0, 0]


def test_draws_can_have_different_numbers_of_ranks():
    u = np.linspace(0, 1, 50, endpoint=False)[:, None]
    n = np.array([1, 4, 9])
    alone = [draw_position(u[:, 0], int(size), 1.5) for size in n]
    assert np.array_equal(draw_position(u, n, 1.5), np.column_stack(alone))
    taus = np.linspace(0, 3, 50)[:, None]
    each = [
        [int(draw_position(u[i], int(size), float(taus[i, 0]))[0]) for size in n] for i in range(50)
    ]
    assert np.array_equal(draw_position(u, n, taus), each)


def test_rank_sorts_feasible_then_infeasible_then_failed_candidates():
    f = np.array([5.0, math.nan, -9.0, 1.0, -8.0, math.inf, 0.0])
    violation = np.array([0.0, 0.0, 2.0, 0.0, 1.0, 0.0, math.nan])
    order = rank(f, violation, np.arange(7) / 7)
    assert order.tolist() == [3, 0, 4, 2, 1, 5, 6]


def test_equal_candidates_are_sorted_at_random():
    rng = np.random.default_rng(2)
    f = np.broadcast_to([1.0, 0.0, 1.0, 1.0], (60_000, 4))
    orders = rank(f, np.zeros_like(f), rng.random(f.shape))
    assert (orders[:, 0] == 1).all()
    _, counts = np.unique(orders[:, 1:], axis=0, return_counts=True)
    assert len(counts) == math.factorial(3)
    assert chisquare(counts).pvalue > 1e-3
