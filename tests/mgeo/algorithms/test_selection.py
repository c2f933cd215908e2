import math

import numpy as np
import pytest
from scipy.stats import chi2_contingency, chisquare

from mgeo import MGEOVar
from mgeo.algorithms import pick, rank

from .. import naive
from .problems import Fixed
from .variants import VARIANTS, canonical, real, var

DRAWS = 200_000


@pytest.mark.parametrize("tau", [0.0, 0.5, 1.0, 3.0])
@pytest.mark.parametrize("n", [1, 2, 12])
def test_pick_follows_the_power_law(n, tau):
    places = pick(np.random.default_rng(0).random(DRAWS), n, tau)
    law = np.array([k**-tau for k in range(1, n + 1)])
    counts = np.bincount(places, minlength=n)
    assert len(counts) == n
    if n > 1:
        assert chisquare(counts, DRAWS * law / law.sum()).pvalue > 1e-3


@pytest.mark.parametrize("tau", [0.5, 3.0])
def test_pick_is_the_law_of_drawing_until_accepted(tau):
    rng = np.random.default_rng(1)
    rejected = np.bincount([naive.rejection_rank(rng, 6, tau) - 1 for _ in range(40_000)])
    picked = np.bincount(pick(rng.random(40_000), 6, tau))
    assert chi2_contingency([rejected, picked]).pvalue > 1e-3


def test_pick_stays_in_range_at_the_ends_of_the_unit_interval():
    ends = np.array([0.0, np.nextafter(1.0, 0.0)])
    assert pick(ends, 12, 0.0).tolist() == [0, 11]
    assert pick(ends, 1, 3.0).tolist() == [0, 0]


def test_pick_takes_one_tau_per_walker():
    u = np.full((3, 1), 0.95)
    tau = np.array([[0.0], [1.0], [50.0]])
    assert pick(u, 10, tau).ravel().tolist() == [int(pick(u[0], 10, t)[0]) for t in (0, 1, 50)]
    assert pick(u, 10, tau).ravel().tolist() == [9, 8, 0]


def test_pick_takes_one_number_of_ranks_per_draw():
    u = np.linspace(0, 1, 50, endpoint=False)[:, None]
    n = np.array([1, 4, 9])
    alone = [pick(u[:, 0], int(size), 1.5) for size in n]
    assert np.array_equal(pick(u, n, 1.5), np.column_stack(alone))
    taus = np.linspace(0, 3, 50)[:, None]
    each = [[int(pick(u[i], int(size), float(taus[i, 0]))[0]) for size in n] for i in range(50)]
    assert np.array_equal(pick(u, n, taus), each)


def accepted_ranks(algorithm, generations, objectives=1):
    """(objectives, size) how often the candidate of each rank is accepted, by size of its group.

    Candidates are given random values, so that every order is as likely.
    """
    algorithm.setup(Fixed([0.0] * objectives), seed=1)
    rng, counts = np.random.default_rng(0), {}
    own = int(algorithm.evaluates_walkers)
    present = algorithm._order >= 0
    for _ in range(generations):
        f = rng.random((len(algorithm.candidates()), objectives))
        proposed = algorithm.proposed.copy()
        before = algorithm.walkers.copy()
        algorithm.accept(f, np.zeros(len(f)))
        by_walker = f.reshape(algorithm.n_walkers, -1, objectives)[:, own:]
        for walker, values in enumerate(by_walker):
            for group, row in enumerate(algorithm._order):
                row = row[present[group]]
                places = algorithm._coordinates[group][present[group]]
                taken = np.flatnonzero(
                    (algorithm.walkers[walker, places] == proposed[walker, group][: len(row)])
                    & (algorithm.walkers[walker, places] != before[walker, places])
                )
                if len(taken) != 1:  # two steps ended at the same bound
                    continue
                ranks = np.argsort(np.argsort(values[row], axis=0), axis=0)[taken[0]]
                counts.setdefault(len(row), np.zeros((objectives, len(row)), dtype=int))
                counts[len(row)][np.arange(objectives), ranks] += 1
    return counts


@pytest.mark.cases(5)
@pytest.mark.parametrize(
    ("variant", "tau"), [(each, 1.3) for each in VARIANTS] + [(real, 0.0), (canonical, 3.0)]
)
def test_every_variant_accepts_by_the_power_law(variant, tau):
    for size, (counts,) in accepted_ranks(variant(tau, 200), 20).items():
        law = np.arange(1.0, size + 1) ** -tau
        assert counts.sum() > 2000
        assert chisquare(counts, counts.sum() * law / law.sum()).pvalue > 1e-3


def test_so_do_groups_of_different_length():
    algorithm = MGEOVar(1.3, 300, bits=[2, 3, 7])
    counts = accepted_ranks(algorithm, 20)
    assert sorted(counts) == [2, 3, 7]
    for size, (of_size,) in counts.items():
        law = np.arange(1.0, size + 1) ** -1.3
        assert chisquare(of_size, of_size.sum() * law / law.sum()).pvalue > 1e-3


@pytest.mark.parametrize("variant", [real, canonical, var])
def test_every_objective_is_as_likely_to_rank_by(variant):
    # under high pressure, walkers take the best of the one objective drawn, independent of others
    counts = accepted_ranks(variant(200.0, 300), 20, objectives=3)
    for size, by_objective in counts.items():
        total = by_objective[0].sum()
        expected = total * (1 / 3 + 2 / 3 / size)
        spread = np.sqrt(total * (1 / 3 + 2 / 3 / size) * (2 / 3) * (1 - 1 / size))
        assert np.abs(by_objective[:, 0] - expected).max() < 4 * spread


def test_rank_puts_feasible_then_infeasible_then_failed():
    f = np.array([5.0, math.nan, -9.0, 1.0, -8.0, math.inf, 0.0])
    violation = np.array([0.0, 0.0, 2.0, 0.0, 1.0, 0.0, math.nan])
    order = rank(f, violation, np.arange(7) / 7)
    assert order.tolist() == [3, 0, 4, 2, 1, 5, 6]


def test_equal_merit_is_ordered_at_random():
    rng = np.random.default_rng(2)
    f = np.broadcast_to([1.0, 0.0, 1.0, 1.0], (60_000, 4))
    orders = rank(f, np.zeros_like(f), rng.random(f.shape))
    assert (orders[:, 0] == 1).all()
    _, counts = np.unique(orders[:, 1:], axis=0, return_counts=True)
    assert len(counts) == math.factorial(3)
    assert chisquare(counts).pvalue > 1e-3
