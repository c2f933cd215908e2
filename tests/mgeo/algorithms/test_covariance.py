"""Matrix adaptation: the evolution strategy, and its use by walkers of MGEODirected."""

import copy
from dataclasses import fields

import numpy as np
import pytest
from pymoo.problems.multi import ZDT1

from mgeo import MGEODirected
from mgeo.algorithms import capture, restore
from mgeo.algorithms.matrix_adaptation import SearchDistributions


class Early(MGEODirected):
    adaptation_delay = 30


class Never(MGEODirected):
    adaptive_share = 0.0


def start_run(algorithm, problem, generations, seed=3):
    run = copy.deepcopy(algorithm).setup(problem, termination=("n_gen", 1000), seed=seed)
    for _ in range(generations):
        run.next()
    return run


def adapt_reference(sigma, matrix, path, z):
    """Adapt one distribution by figure 3 of Beyer & Sendhoff in plain loops; z is best first."""
    size, n = z.shape
    mu = size // 2
    raw = [np.log(mu + 0.5) - np.log(i) for i in range(1, mu + 1)]
    w = [each / sum(raw) for each in raw]
    mueff = 1 / sum(each**2 for each in w)
    cs = (mueff + 2) / (n + mueff + 5)
    c1 = 2 / ((n + 1.3) ** 2 + mueff)
    cw = min(1 - c1, 2 * (mueff - 2 + 1 / mueff) / ((n + 2) ** 2 + mueff))
    ds = 1 + cs + 2 * max(0, np.sqrt((mueff - 1) / (n + 1)) - 1)
    chi = np.sqrt(n) * (1 - 1 / (4 * n) + 1 / (21 * n**2))
    zw = sum(w[i] * z[i] for i in range(mu))
    step = sigma * sum(w[i] * matrix @ z[i] for i in range(mu))
    path = (1 - cs) * path + np.sqrt(mueff * cs * (2 - cs)) * zw
    one = np.eye(n)
    of_sample = sum(w[i] * np.outer(z[i], z[i]) for i in range(mu))
    new = matrix @ (one + c1 / 2 * (np.outer(path, path) - one) + cw / 2 * (of_sample - one))
    return step, sigma * np.exp(cs / ds * (np.linalg.norm(path) / chi - 1)), new, path


@pytest.mark.parametrize(("n", "n_candidates"), [(1, 1), (2, 2), (7, 3), (30, 3)])
def test_adaptation_agrees_with_published_strategy(n, n_candidates):
    rng = np.random.default_rng(1)
    distributions = SearchDistributions.create(4, n, 2, n_candidates)
    size = distributions.z.shape[1]
    assert size % n_candidates == 0
    assert size >= 4 + int(3 * np.log(n))
    distributions.reset(np.arange(4), np.array([0.1, 0.2, 0.3, 0.01]))
    for _ in range(3):
        before = [
            copy.copy(distributions.sigma),
            distributions.matrix.copy(),
            distributions.path.copy(),
        ]
        full = [
            distributions.add_evaluations(
                np.zeros((4, n_candidates, 2)), np.zeros((4, n_candidates))
            )
            for _ in range(size // n_candidates)
            if distributions.draw_steps(n_candidates, rng) is not None
        ]
        assert full == [False] * (len(full) - 1) + [True]
        z, ranking = distributions.z.copy(), rng.permuted(np.tile(np.arange(size), (4, 1)), axis=1)
        steps = distributions.adapt(ranking)
        for k in range(4):
            expected = adapt_reference(*(each[k] for each in before), z[k, ranking[k]])
            found = steps[k], distributions.sigma[k], distributions.matrix[k], distributions.path[k]
            for one, other in zip(found, expected, strict=True):
                np.testing.assert_allclose(one, other, rtol=1e-10, atol=1e-13)


def test_distribution_adapts_to_ill_conditioned_ellipsoid():
    rng = np.random.default_rng(2)
    n, axes = 6, np.logspace(0, 3, 6)
    rotation = np.linalg.qr(rng.standard_normal((n, n)))[0]
    distributions, mean = SearchDistributions.create(1, n, 1, 3), np.full((1, n), 3.0)
    distributions.reset(np.arange(1), np.array([1.0]))
    for generation in range(1800):
        points = mean[:, None] + distributions.draw_steps(3, rng)
        f = ((points @ rotation * axes) ** 2).sum(axis=2, keepdims=True)
        if distributions.add_evaluations(f, np.zeros((1, 3))):
            mean = mean + distributions.adapt(distributions.F[:, :, 0].argsort(axis=1))
        if generation == 100:
            early = f.min()
    assert f.min() < 1e-12 * early
    lengths = np.linalg.svd(distributions.matrix[0], compute_uv=False)
    assert lengths[0] / lengths[-1] == pytest.approx(1e3, rel=0.7)


def test_half_of_walkers_adapt_covariance_after_delay():
    problem = ZDT1(n_var=4)
    run, never = start_run(Early(), problem, 2), start_run(Never(), problem, 2)
    assert not len(run._select_adapting_walkers())
    np.testing.assert_array_equal(run.front.F, never.front.F)
    run.next(), never.next()  # 144 evaluations exceed the delay of 120.
    np.testing.assert_array_equal(run.front.F, never.front.F)
    kinds = run.state.weights.max(axis=1) < 1
    rows = run._select_adapting_walkers()
    assert sorted(rows) == [3, 4, 5, 11, 12, 13, 14, 15]
    assert kinds.tolist() == [False] * 6 + [True] * 10
    run.next(), never.next()
    assert not np.array_equal(run.front.F, never.front.F)
    assert (run.walkers >= 0).all()
    assert (run.walkers <= 1).all()


def test_resumed_run_with_adaptive_covariance_equals_uninterrupted_run():
    run = start_run(Early(), ZDT1(n_var=4), 7)
    assert run.state.distributions.n_drawn
    restored = restore(capture(run), run.problem, Early())
    for _ in range(20):
        run.next(), restored.next()
    np.testing.assert_array_equal(restored.front.F, run.front.F)
    for field in fields(SearchDistributions):
        assert np.array_equal(
            getattr(restored.state.distributions, field.name),
            getattr(run.state.distributions, field.name),
        )
