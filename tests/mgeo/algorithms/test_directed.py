"""MGEODirected: weights, steps, incumbents, migration and restarts."""

import copy

import numpy as np
import pytest
from pymoo.core.problem import Problem
from pymoo.indicators.hv import HV
from pymoo.optimize import minimize
from pymoo.problems.multi import BNH, ZDT1
from scipy.stats import kstest

from mgeo import MGEODirected
from mgeo.algorithms.moves import Attraction, draw_joint_steps, draw_momentum_steps
from mgeo.algorithms.selection import (
    build_weight_vectors,
    draw_weights,
    find_nearest,
    find_nearest_in_sample,
    tchebycheff_distance,
)

from .problems import Fixed, Rosenbrock

NEVER = 10**9
STILL = {"return_probability": 0.0, "migration_probability": (0.0, 0.0), "patience": (NEVER, NEVER)}


def directed(*args, **parameters):
    """Build MGEODirected with other parameters and class constants."""
    constants = {key: parameters.pop(key) for key in list(parameters) if hasattr(MGEODirected, key)}
    return type("Changed", (MGEODirected,), constants)(*args, **parameters)


def start_run(algorithm, problem, generations=1, seed=5):
    run = copy.deepcopy(algorithm).setup(problem, termination=("n_gen", 1000), seed=seed)
    for _ in range(generations):
        run.next()
    return run


def candidates(run):
    """Return the next candidates, shape (n_walkers, n_candidates, n_var), and the walkers."""
    walkers = run.walkers.copy()
    return run.ask().get("X").reshape(run.n_walkers, -1, walkers.shape[1]), walkers


def test_weights_of_two_objectives_are_extremes_and_even_grid():
    for n in range(1, 40):
        middle = 1.0 / n * (np.arange(n) + 0.5)
        assert (
            build_weight_vectors(n, 2, 0.0).tolist()
            == np.column_stack([middle, 1.0 - middle]).tolist()
        )
    weights = build_weight_vectors(7, 2, 0.43)
    assert weights[:3].tolist() == [[1, 0], [0, 1], [1, 0]]
    assert weights[3:, 0] == pytest.approx([0.125, 0.375, 0.625, 0.875])
    assert weights.sum(axis=1) == pytest.approx(np.ones(7))


@pytest.mark.parametrize("n_obj", [1, 3, 5, 9, 15, 30])
def test_weights_fill_simplex_evenly(n_obj):
    weights = build_weight_vectors(2000, n_obj, 0.0)
    assert (weights > 0).all()
    assert (weights < 1).all() or n_obj == 1
    assert weights.sum(axis=1) == pytest.approx(np.ones(2000))
    assert weights.mean(axis=0) == pytest.approx(np.full(n_obj, 1 / n_obj), abs=0.01)
    # Spacings of n_obj - 1 uniform points have the variance (n_obj - 1) / (n_obj^2 (n_obj + 1)).
    variance = (n_obj - 1) / (n_obj**2 * (n_obj + 1))
    assert weights.var(axis=0) == pytest.approx(np.full(n_obj, variance), abs=0.01)


@pytest.mark.parametrize("n_obj", [1, 2, 4])
def test_drawn_weights_are_uniform_on_simplex(n_obj):
    weights = draw_weights(20_000, n_obj, np.random.default_rng(1))
    assert (weights >= 0).all()
    assert weights.sum(axis=1) == pytest.approx(np.ones(20_000))
    variance = (n_obj - 1) / (n_obj**2 * (n_obj + 1))
    assert weights.mean(axis=0) == pytest.approx(np.full(n_obj, 1 / n_obj), abs=0.01)
    assert weights.var(axis=0) == pytest.approx(np.full(n_obj, variance), abs=0.01)


def test_distance_is_largest_weighted_scaled_objective():
    F = np.array([[2.0, 30.0], [3.0, 10.0], [np.nan, 1.0]])
    found = tchebycheff_distance(
        F, np.array([0.25, 0.75]), np.array([1.0, 10.0]), np.array([5.0, 50.0])
    )
    assert found[:2] == pytest.approx([0.75 * 0.5, 0.25 * 0.5], abs=2e-3)
    assert np.isnan(found[2])


@pytest.mark.parametrize("n_obj", [1, 2, 3, 5])
def test_nearest_point_has_smallest_distance(n_obj):
    rng = np.random.default_rng(n_obj)
    F = rng.random((500, n_obj))
    weights = np.vstack([draw_weights(20, n_obj, rng), np.eye(n_obj)])
    F[100:110] = F[:10]  # Equal points, of which the first must be found.
    F[:, -1] = np.where(n_obj == 5, 3.0, F[:, -1])  # An objective without extent.
    ideal_and_nadir = F.min(axis=0), F.max(axis=0)
    expected = tchebycheff_distance(F, weights[:, None], *ideal_and_nadir).argmin(axis=1)
    assert find_nearest(F, weights, *ideal_and_nadir).tolist() == expected.tolist()


@pytest.mark.parametrize(("n_obj", "n_sampled"), [(1, 4), (2, 1), (2, 7), (3, 20)])
def test_nearest_point_of_sample_is_found_for_each_weight_vector(n_obj, n_sampled):
    rng = np.random.default_rng(n_sampled)
    F, weights = rng.random((50, n_obj)), draw_weights(30, n_obj, rng)
    drawn, ideal_and_nadir = rng.integers(50, size=(30, n_sampled)), (F.min(axis=0), F.max(axis=0))
    found = find_nearest_in_sample(drawn, F, weights, *ideal_and_nadir)
    for weight, rows, row in zip(weights, drawn, found, strict=True):
        assert row in rows
        assert row == min(rows, key=lambda k: tchebycheff_distance(F[k], weight, *ideal_and_nadir))


def test_candidate_changes_primary_variable_and_others_by_coupling():
    problem = ZDT1(n_var=6)
    changed = np.zeros((6, 6))
    for seed in range(60):
        run = start_run(
            directed(n_walkers=5, coupling=(0.2, 0.5), difference=(0, 0), max_candidates=6),
            problem,
            0,
            seed,
        )
        X, walkers = candidates(run)
        interior = (walkers > 0) & (walkers < 1)
        assert interior.all()
        changed += (walkers[:, None] != X).sum(axis=0)
    changed /= 300
    assert np.diag(changed) == pytest.approx(np.ones(6), abs=0.01)
    others = changed[~np.eye(6, dtype=bool)]
    assert others.mean() == pytest.approx(0.2, abs=0.02)


@pytest.mark.parametrize("mean", [0.0, 0.2, 0.5, 1.0])
def test_number_of_changed_variables_is_beta_binomial(mean):
    primary = np.tile(np.arange(11), 4000)
    rng = np.random.default_rng(2)
    steps, _, _ = draw_joint_steps(primary, np.ones(11), (0.1, 0.1), (mean, 0.9), 0.5, None, rng)
    others = np.count_nonzero(steps, axis=1) - 1
    assert (steps[np.arange(len(primary)), primary] != 0).all()
    assert others.mean() / 10 == pytest.approx(mean, abs=0.01)
    if 0 < mean < 1:  # Beta-binomial with alpha = mean / (1 - mean) and beta = 1.
        alpha = mean / (1 - mean)
        variance = 10 * alpha * (alpha + 11) / ((alpha + 1) ** 2 * (alpha + 2))
        assert others.var() == pytest.approx(variance, rel=0.05)


def test_normal_steps_have_log_uniform_standard_deviation():
    rng = np.random.default_rng(3)
    primary, extent = np.tile([0, 1], 20_000), np.array([1.0, 50.0])
    steps, _, _ = draw_joint_steps(primary, extent, (0.01, 1.0), (0.0, 0.0), 0.0, None, rng)
    sizes = np.abs(steps[np.arange(len(primary)), primary]) / extent[primary]
    # The size is a log-uniform sigma times |N(0, 1)|, whose mean logarithm is -(gamma + ln 2) / 2.
    expected = 0.5 * np.log(0.01) - (np.euler_gamma + np.log(2)) / 2
    assert np.log(sizes).mean() == pytest.approx(expected, abs=0.03)


def test_attraction_adds_random_fraction_of_offset_to_target():
    rng = np.random.default_rng(4)
    primary = np.tile(np.arange(5), 6000)
    x, target, offset = (rng.standard_normal((len(primary), 5)) for _ in range(3))
    zero = np.zeros_like(x)
    for share, difference in ((1.0, zero), (0.3, zero), (0.5, offset)):
        attraction = Attraction(share, 1.0, x, target)
        donors = lambda _, first=difference: (first, zero)  # noqa: E731
        steps, _, first = draw_joint_steps(
            primary, np.ones(5), (0.1, 0.1), (0.0, 0.0), 1.0, donors, rng, attraction
        )
        is_attracted = (steps != 0.0).all(axis=1)  # All other steps change at most one variable.
        assert is_attracted.mean() == pytest.approx(share, abs=0.02)
        np.testing.assert_array_equal(first[is_attracted], target[is_attracted])
        np.testing.assert_array_equal(first[~is_attracted], difference[~is_attracted])
        # Each step is v (first - second) + w (target - x), with two unknowns in five equations.
        for step, a, b in zip(
            steps[is_attracted][:200],
            difference[is_attracted],
            (target - x)[is_attracted],
            strict=False,
        ):
            solved = np.linalg.lstsq(np.column_stack([a, b]), step)[0]
            np.testing.assert_allclose(solved[0] * a + solved[1] * b, step, atol=1e-12)
            assert ((solved > -1e-12) & (solved < 1.0)).all()


def test_momentum_steps_combine_previous_step_and_offset_to_target():
    rng = np.random.default_rng(6)
    x, before, target = (0.1 * rng.random((5000, 4)) for _ in range(3))
    zero = np.zeros_like(x)
    inertia_factors = draw_momentum_steps(x, before, x, np.ones(4), rng) / before
    target_factors = draw_momentum_steps(x, zero, target, np.ones(4), rng) / (target - x)
    # The factors are uniform and independent between variables.
    for found, largest in ((inertia_factors, 1.2), (target_factors, 1.0)):
        assert kstest(found.ravel() / largest, "uniform").pvalue > 0.01
        assert np.abs(np.corrcoef(found.T) - np.eye(4)).max() < 0.05
    both = draw_momentum_steps(x, before, target, np.ones(4), rng)
    expected = 0.6 * before + 0.5 * (target - x)
    assert (both - expected).mean(axis=0) == pytest.approx(np.zeros(4), abs=0.002)


def test_momentum_steps_are_limited_to_fifth_of_bounds():
    extent = np.array([1.0, 100.0])
    steps = draw_momentum_steps(
        np.zeros((400, 2)), extent, -9.0 * extent, extent, np.random.default_rng(7)
    )
    assert (np.abs(steps) <= 0.2 * extent).all()
    assert {-0.2, 0.2} <= set((steps / extent).ravel())


def test_momentum_is_step_that_led_to_incumbent():
    run = start_run(directed(n_walkers=6, **STILL), ZDT1(n_var=5), 0)
    assert not run.state.momentum.any()
    changed = 0
    for _ in range(25):
        start, before = run.walkers.copy(), copy.deepcopy(run.state)
        run.next()
        new = (run.state.incumbents != before.incumbents).any(axis=1)
        step = run.state.incumbents - start
        np.testing.assert_array_equal(run.state.momentum[new], step[new])
        np.testing.assert_array_equal(run.state.momentum[~new], before.momentum[~new])
        changed += new.sum()
    assert 20 < changed < 25 * 6


def test_walkers_with_high_tau_accept_nearest_candidate():
    run = start_run(directed(60.0, 6, max_candidates=5, **STILL), ZDT1(n_var=5), 4)
    infills = run.ask()
    run.evaluator.eval(run.problem, infills)
    X, F = infills.get("X").reshape(6, 5, 5).copy(), infills.get("F").reshape(6, 5, 2).copy()
    run.tell(infills=infills)
    ideal, nadir = run.front.F.min(axis=0), run.front.F.max(axis=0)
    best = tchebycheff_distance(F, run.state.weights[:, None], ideal, nadir).argmin(axis=1)
    assert np.array_equal(run.walkers, X[np.arange(6), best])


def test_incumbent_is_best_point_of_each_walker():
    problem = Rosenbrock(3)
    run = start_run(directed(n_walkers=4, **STILL), problem, 0)
    best = np.full(4, np.inf)
    for _ in range(20):
        infills = run.ask()
        run.evaluator.eval(problem, infills)
        best = np.minimum(best, infills.get("F").reshape(4, -1).min(axis=1))
        run.tell(infills=infills)
        assert np.array_equal(run.state.incumbent_F[:, 0], best)
        assert np.array_equal(problem.evaluate(run.state.incumbents)[:, 0], best)


def test_walkers_return_to_incumbent_or_nearest_archived_point():
    run = start_run(
        directed(n_walkers=5, return_probability=1.0, migration_probability=(0.0, 0.0)),
        ZDT1(n_var=4),
        6,
    )
    assert np.array_equal(run.walkers, run.state.incumbents)
    run = start_run(
        directed(n_walkers=5, return_probability=0.0, migration_probability=(1.0, 0.0)),
        ZDT1(n_var=4),
        6,
    )
    ideal, nadir = run.front.F.min(axis=0), run.front.F.max(axis=0)
    has_mixed_weights = run.state.weights.max(axis=1) < 1
    assert has_mixed_weights.tolist() == [False, False, True, True, True]
    for walker in np.flatnonzero(has_mixed_weights):
        distances = tchebycheff_distance(run.front.F, run.state.weights[walker], ideal, nadir)
        assert np.array_equal(run.walkers[walker], run.front.individuals[distances.argmin()].X)
        assert np.array_equal(run.state.incumbent_F[walker], run.front.F[distances.argmin()])
    archived = run.front.individuals.get("X")
    assert not (run.walkers[~has_mixed_weights][:, None] == archived).all(axis=2).all()


def test_walker_without_progress_restarts():
    problem = Fixed([0.5, 0.5])  # All candidates are equal.
    options = {**STILL, "patience": (3, 5)}
    run = start_run(directed(n_walkers=5, extreme_weights=0.4, **options), problem, 3)
    has_mixed_weights = np.array([False, False, True, True, True])
    first, incumbents = build_weight_vectors(5, 2, 0.4), run.state.incumbents.copy()
    assert np.array_equal(run.state.weights, first)
    assert run.state.n_idle_generations.tolist() == [2, 2, 2, 2, 2]
    run.next()
    assert run.state.n_idle_generations.tolist() == [3, 3, 0, 0, 0]
    assert (run.state.weights[has_mixed_weights] != first[has_mixed_weights]).all()
    assert np.array_equal(run.state.weights[~has_mixed_weights], first[~has_mixed_weights])
    archived = run.front.individuals.get("X")
    assert (run.walkers[has_mixed_weights][:, None] == archived).all(axis=2).any(axis=1).all()
    assert np.array_equal(run.state.incumbents[~has_mixed_weights], incumbents[~has_mixed_weights])
    run.next()
    run.next()
    assert run.state.n_idle_generations[~has_mixed_weights].tolist() == [0, 0]
    assert np.array_equal(run.state.weights[~has_mixed_weights], first[~has_mixed_weights])
    assert not (run.state.incumbents[~has_mixed_weights] == incumbents[~has_mixed_weights]).any()
    assert np.isinf(run.state.incumbent_F[~has_mixed_weights]).all()
    assert np.isinf(run.state.incumbent_violation[~has_mixed_weights]).all()


class Creep(Problem):
    """Infeasible problem whose violation is the distance from a corner outside the bounds."""

    def __init__(self):
        super().__init__(n_var=3, n_obj=2, n_ieq_constr=1, xl=0.0, xu=1.0)

    def _evaluate(self, X, out, *args, **kwargs):
        out["F"] = X[:, :2]
        out["G"] = 4.0 - X.sum(axis=1)


def test_decrease_of_violation_is_progress():
    run = start_run(
        directed(
            n_walkers=4,
            extreme_weights=1.0,
            patience=(1, 1),
            return_probability=1.0,
            migration_probability=(0, 0),
        ),
        Creep(),
    )
    for _ in range(30):
        before = run.state.incumbent_violation.copy()
        run.next()
        less = run.state.incumbent_violation < before
        assert (run.state.n_idle_generations == 0).all()  # Progress or a restart.
        assert (less | np.isinf(run.state.incumbent_violation)).all()
    assert np.isinf(run.state.incumbent_violation).any()


def test_constrained_front_is_feasible_and_complete():
    problem = BNH()
    result = minimize(problem, MGEODirected(n_walkers=8), ("n_gen", 150), seed=1)
    assert np.all(result.CV == 0)
    area = HV(ref_point=np.array([140.0, 50.0]))
    assert area(result.F) > 0.995 * area(problem.pareto_front())
