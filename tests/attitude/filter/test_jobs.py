"""Tree of filter jobs, compared with sequences of rates that are written out step by step."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mgeo_attitude.filter.jobs import build_shared_jobs
from mgeo_attitude.maneuvers.schedule import compute_maneuver_steps, decode_designs


def list_step_rates(rates, starts, n_steps):
    """Return the body rate at each step of one design."""
    return [tuple(rates[np.flatnonzero(starts <= k)[-1]]) for k in range(n_steps)]


def check_jobs(X, n_steps):
    rates, durations = decode_designs(X)
    starts, end_steps = compute_maneuver_steps(durations, 1.0)
    jobs = build_shared_jobs(
        rates, starts, end_steps, n_steps, np.zeros(len(rates), dtype=np.int64)
    )
    step_rates = [list_step_rates(r, s, n_steps) for r, s in zip(rates, starts, strict=True)]
    leaves = jobs.design[jobs.end < 0]
    # Each design or its representative is run once.
    assert sorted(leaves) == sorted(set(jobs.representative))
    for i, representative in enumerate(jobs.representative):
        assert step_rates[i] == step_rates[representative]
        assert end_steps[i] == end_steps[representative]
    for job in np.flatnonzero(jobs.end < 0):
        # From the end back to the start, the steps of all parent jobs are those of the design.
        design, k = jobs.design[job], n_steps
        while True:
            assert step_rates[jobs.design[job]][:k] == step_rates[design][:k]
            k, parent = jobs.begin[job], jobs.parent[job]
            if parent < 0:
                break
            assert parent < job
            assert jobs.end[parent] == k
            assert jobs.snapshot[parent] >= 0
            # A design branches off before its convergence is tested.
            assert k < min(end_steps[design], n_steps)
            job = parent
        assert k == 0
    inner = jobs.snapshot[jobs.end >= 0]
    assert sorted(inner) == list(range(len(inner)))
    return jobs


rate = st.sampled_from([0.0, 0.5, 1.0])
duration = st.sampled_from([0.0, 0.4, 17.0, 17.3, 25.0, 40.0, 90.0])
maneuver = st.tuples(rate, rate, rate, duration)


@pytest.mark.slow
@settings(max_examples=300, deadline=None)
@given(st.lists(st.tuples(maneuver, maneuver, maneuver), min_size=1, max_size=12))
def test_jobs_reproduce_all_designs(designs):
    check_jobs(np.array(designs).reshape(len(designs), -1), n_steps=100)


@pytest.mark.parametrize("seed", range(2))
def test_candidates_of_one_walker_share_initial_maneuvers(seed):
    """The 12 designs each differ from the walker in one variable."""
    rng = np.random.default_rng(seed)
    x = rng.uniform(-1.0, 1.0, 12)
    x[3::4] = [100.0, 200.0, 150.0]
    X = np.tile(x, (12, 1))
    X[np.diag_indices(12)] += 0.1
    X[[3, 7, 11], [3, 7, 11]] += 50.0
    jobs = check_jobs(X, n_steps=1000)
    run = np.where(jobs.end < 0, 1000, jobs.end) - jobs.begin
    # Maneuver 1 is run once for nine candidates, and maneuver 2 once for five.
    assert run.sum() == 12 * 1000 - 8 * 100 - 4 * 200


def test_random_designs_share_no_steps():
    rng = np.random.default_rng(0)
    X = rng.uniform(0.1, 1.0, (50, 12))
    X[:, 3::4] *= 100.0
    jobs = check_jobs(X, n_steps=400)
    assert len(jobs.design) == 50
    assert (jobs.snapshot < 0).all()


def test_equal_designs_are_run_once():
    X = np.tile(np.linspace(0.1, 40.0, 12), (7, 1))
    assert len(check_jobs(X, n_steps=400).design) == 1


def test_different_variants_share_no_steps():
    """Each variant has the same jobs as in a separate batch, from its own initial state."""
    rng = np.random.default_rng(8)
    X = np.tile(rng.uniform(5.0, 40.0, 12), (9, 1))
    X[:, 8] = rng.integers(0, 3, 9)
    variants = np.array([0, 1, 2] * 3)
    rates, durations = decode_designs(X)
    given = rates, *compute_maneuver_steps(durations, 1.0)
    jobs = build_shared_jobs(*given, 400, variants)
    apart = 0
    for k in range(3):
        is_variant = variants == k
        own = build_shared_jobs(
            *(part[is_variant] for part in given), 400, np.full(is_variant.sum(), k)
        )
        apart += len(own.design)
    assert len(jobs.design) == apart
    for job, parent in enumerate(jobs.parent):
        own = variants[jobs.design[job]]
        assert parent == -1 - own if parent < 0 else variants[jobs.design[parent]] == own
    assert (variants[jobs.representative] == variants).all()
