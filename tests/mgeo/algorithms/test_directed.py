"""MGEODirected: what each of its parts does, and that it finds whole fronts."""

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


def directed(*args, **given):
    """The algorithm with other constants among what is given."""
    constants = {key: given.pop(key) for key in list(given) if hasattr(MGEODirected, key)}
    return type("Changed", (MGEODirected,), constants)(*args, **given)


def begun(algorithm, problem, generations=1, seed=5):
    run = copy.deepcopy(algorithm).setup(problem, termination=("n_gen", 1000), seed=seed)
    for _ in range(generations):
        run.next()
    return run


def candidates(run):
    """(n_walkers, n_candidates, n_var) of the next generation, and where they start from."""
    walkers = run.walkers.copy()
    return run.ask().get("X").reshape(run.n_walkers, -1, walkers.shape[1]), walkers


def test_directions_of_two_objectives_are_the_ends_and_an_even_grid():
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
def test_directions_fill_the_simplex(n_obj):
    weights = build_weight_vectors(2000, n_obj, 0.0)
    assert (weights > 0).all()
    assert (weights < 1).all() or n_obj == 1
    assert weights.sum(axis=1) == pytest.approx(np.ones(2000))
    assert weights.mean(axis=0) == pytest.approx(np.full(n_obj, 1 / n_obj), abs=0.01)
    # spacings of n_obj - 1 uniform points: variance (n_obj - 1) / (n_obj^2 (n_obj + 1))
    variance = (n_obj - 1) / (n_obj**2 * (n_obj + 1))
    assert weights.var(axis=0) == pytest.approx(np.full(n_obj, variance), abs=0.01)


@pytest.mark.parametrize("n_obj", [1, 2, 4])
def test_drawn_directions_are_uniform_on_the_simplex(n_obj):
    weights = draw_weights(20_000, n_obj, np.random.default_rng(1))
    assert (weights >= 0).all()
    assert weights.sum(axis=1) == pytest.approx(np.ones(20_000))
    variance = (n_obj - 1) / (n_obj**2 * (n_obj + 1))
    assert weights.mean(axis=0) == pytest.approx(np.full(n_obj, 1 / n_obj), abs=0.01)
    assert weights.var(axis=0) == pytest.approx(np.full(n_obj, variance), abs=0.01)


def test_distance_is_the_largest_weighted_objective_of_the_scaled_space():
    F = np.array([[2.0, 30.0], [3.0, 10.0], [np.nan, 1.0]])
    found = tchebycheff_distance(
        F, np.array([0.25, 0.75]), np.array([1.0, 10.0]), np.array([5.0, 50.0])
    )
    assert found[:2] == pytest.approx([0.75 * 0.5, 0.25 * 0.5], abs=2e-3)
    assert np.isnan(found[2])


@pytest.mark.parametrize("n_obj", [1, 2, 3, 5])
def test_the_nearest_point_is_that_of_the_least_distance(n_obj):
    rng = np.random.default_rng(n_obj)
    F = rng.random((500, n_obj))
    weights = np.vstack([draw_weights(20, n_obj, rng), np.eye(n_obj)])
    F[100:110] = F[:10]  # of points equally near the first
    F[:, -1] = np.where(n_obj == 5, 3.0, F[:, -1])  # an objective without extent
    ends = F.min(axis=0), F.max(axis=0)
    expected = tchebycheff_distance(F, weights[:, None], *ends).argmin(axis=1)
    assert find_nearest(F, weights, *ends).tolist() == expected.tolist()


@pytest.mark.parametrize(("n_obj", "few"), [(1, 4), (2, 1), (2, 7), (3, 20)])
def test_of_the_points_drawn_for_a_weight_vector_the_nearest_is_found(n_obj, few):
    rng = np.random.default_rng(few)
    F, weights = rng.random((50, n_obj)), draw_weights(30, n_obj, rng)
    drawn, ends = rng.integers(50, size=(30, few)), (F.min(axis=0), F.max(axis=0))
    found = find_nearest_in_sample(drawn, F, weights, *ends)
    for weight, rows, row in zip(weights, drawn, found, strict=True):
        assert row in rows
        assert row == min(rows, key=lambda k: tchebycheff_distance(F[k], weight, *ends))


def test_a_candidate_changes_its_own_variable_and_others_as_often_as_said():
    problem = ZDT1(n_var=6)
    changed = np.zeros((6, 6))
    for seed in range(60):
        run = begun(
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
def test_each_step_draws_how_many_variables_it_changes(mean):
    own = np.tile(np.arange(11), 4000)
    rng = np.random.default_rng(2)
    steps, _, _ = draw_joint_steps(own, np.ones(11), (0.1, 0.1), (mean, 0.9), 0.5, None, rng)
    others = np.count_nonzero(steps, axis=1) - 1
    assert (steps[np.arange(len(own)), own] != 0).all()
    assert others.mean() / 10 == pytest.approx(mean, abs=0.01)
    if 0 < mean < 1:  # beta-binomial with alpha = mean / (1 - mean), beta = 1
        alpha = mean / (1 - mean)
        variance = 10 * alpha * (alpha + 11) / ((alpha + 1) ** 2 * (alpha + 2))
        assert others.var() == pytest.approx(variance, rel=0.05)


def test_normal_steps_are_as_wide_as_said():
    rng = np.random.default_rng(3)
    own, extent = np.tile([0, 1], 20_000), np.array([1.0, 50.0])
    steps, _, _ = draw_joint_steps(own, extent, (0.01, 1.0), (0.0, 0.0), 0.0, None, rng)
    sizes = np.abs(steps[np.arange(len(own)), own]) / extent[own]
    # a log-uniform width times |N(0, 1)|, whose mean logarithm is -(gamma + ln 2) / 2
    expected = 0.5 * np.log(0.01) - (np.euler_gamma + np.log(2)) / 2
    assert np.log(sizes).mean() == pytest.approx(expected, abs=0.03)


def test_attraction_adds_a_part_of_the_way_to_a_point():
    rng = np.random.default_rng(4)
    own = np.tile(np.arange(5), 6000)
    x, target, between = (rng.standard_normal((len(own), 5)) for _ in range(3))
    zero = np.zeros_like(x)
    for share, difference in ((1.0, zero), (0.3, zero), (0.5, between)):
        attraction = Attraction(share, 1.0, x, target)
        donors = lambda _, first=difference: (first, zero)  # noqa: E731
        steps, _, first = draw_joint_steps(
            own, np.ones(5), (0.1, 0.1), (0.0, 0.0), 1.0, donors, rng, attraction
        )
        pulled = (steps != 0.0).all(axis=1)  # the others change their own variable alone, or none
        assert pulled.mean() == pytest.approx(share, abs=0.02)
        np.testing.assert_array_equal(first[pulled], target[pulled])
        np.testing.assert_array_equal(first[~pulled], difference[~pulled])
        # each step is v (first - second) + w (target - x): two unknowns, five equations
        for step, a, b in zip(
            steps[pulled][:200],
            difference[pulled],
            (target - x)[pulled],
            strict=False,
        ):
            solved = np.linalg.lstsq(np.column_stack([a, b]), step)[0]
            np.testing.assert_allclose(solved[0] * a + solved[1] * b, step, atol=1e-12)
            assert ((solved > -1e-12) & (solved < 1.0)).all()


def test_steps_with_momentum_are_parts_of_the_step_before_and_of_the_way_to_a_target():
    rng = np.random.default_rng(6)
    x, before, target = (0.1 * rng.random((5000, 4)) for _ in range(3))
    zero = np.zeros_like(x)
    gone = draw_momentum_steps(x, before, x, np.ones(4), rng) / before
    drawn = draw_momentum_steps(x, zero, target, np.ones(4), rng) / (target - x)
    for found, largest in ((gone, 1.2), (drawn, 1.0)):  # of each variable its own, uniform
        assert kstest(found.ravel() / largest, "uniform").pvalue > 0.01
        assert np.abs(np.corrcoef(found.T) - np.eye(4)).max() < 0.05
    both = draw_momentum_steps(x, before, target, np.ones(4), rng)
    expected = 0.6 * before + 0.5 * (target - x)
    assert (both - expected).mean(axis=0) == pytest.approx(np.zeros(4), abs=0.002)


def test_a_step_with_momentum_is_at_most_a_fifth_of_the_bounds():
    extent = np.array([1.0, 100.0])
    steps = draw_momentum_steps(
        np.zeros((400, 2)), extent, -9.0 * extent, extent, np.random.default_rng(7)
    )
    assert (np.abs(steps) <= 0.2 * extent).all()
    assert {-0.2, 0.2} <= set((steps / extent).ravel())


def test_the_momentum_is_the_step_that_led_to_the_incumbent():
    run = begun(directed(n_walkers=6, **STILL), ZDT1(n_var=5), 0)
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


def test_walkers_under_high_pressure_take_the_nearest_candidate_along_their_direction():
    run = begun(directed(60.0, 6, max_candidates=5, **STILL), ZDT1(n_var=5), 4)
    infills = run.ask()
    run.evaluator.eval(run.problem, infills)
    X, F = infills.get("X").reshape(6, 5, 5).copy(), infills.get("F").reshape(6, 5, 2).copy()
    run.tell(infills=infills)
    ideal, nadir = run.front.F.min(axis=0), run.front.F.max(axis=0)
    best = tchebycheff_distance(F, run.state.weights[:, None], ideal, nadir).argmin(axis=1)
    assert np.array_equal(run.walkers, X[np.arange(6), best])


def test_memory_is_the_best_point_of_each_walker():
    problem = Rosenbrock(3)
    run = begun(directed(n_walkers=4, **STILL), problem, 0)
    best = np.full(4, np.inf)
    for _ in range(20):
        infills = run.ask()
        run.evaluator.eval(problem, infills)
        best = np.minimum(best, infills.get("F").reshape(4, -1).min(axis=1))
        run.tell(infills=infills)
        assert np.array_equal(run.state.incumbent_F[:, 0], best)
        assert np.array_equal(problem.evaluate(run.state.incumbents)[:, 0], best)


def test_walkers_go_back_to_their_memory_or_to_the_archive():
    run = begun(
        directed(n_walkers=5, return_probability=1.0, migration_probability=(0.0, 0.0)),
        ZDT1(n_var=4),
        6,
    )
    assert np.array_equal(run.walkers, run.state.incumbents)
    run = begun(
        directed(n_walkers=5, return_probability=0.0, migration_probability=(1.0, 0.0)),
        ZDT1(n_var=4),
        6,
    )
    ideal, nadir = run.front.F.min(axis=0), run.front.F.max(axis=0)
    between = run.state.weights.max(axis=1) < 1
    assert between.tolist() == [False, False, True, True, True]
    for walker in np.flatnonzero(between):
        far = tchebycheff_distance(run.front.F, run.state.weights[walker], ideal, nadir)
        assert np.array_equal(run.walkers[walker], run.front.individuals[far.argmin()].X)
        assert np.array_equal(run.state.incumbent_F[walker], run.front.F[far.argmin()])
    archived = run.front.individuals.get("X")
    assert not (run.walkers[~between][:, None] == archived).all(axis=2).all()


def test_a_walker_without_progress_restarts():
    still = Fixed([0.5, 0.5])  # no candidate is ever better than another
    options = {**STILL, "patience": (3, 5)}
    run = begun(directed(n_walkers=5, extreme_weights=0.4, **options), still, 3)
    between = np.array([False, False, True, True, True])
    first, memory = build_weight_vectors(5, 2, 0.4), run.state.incumbents.copy()
    assert np.array_equal(run.state.weights, first)
    assert run.state.n_idle_generations.tolist() == [2, 2, 2, 2, 2]
    run.next()
    assert run.state.n_idle_generations.tolist() == [3, 3, 0, 0, 0]
    assert (run.state.weights[between] != first[between]).all()
    assert np.array_equal(run.state.weights[~between], first[~between])
    archived = run.front.individuals.get("X")
    assert (run.walkers[between][:, None] == archived).all(axis=2).any(axis=1).all()
    assert np.array_equal(run.state.incumbents[~between], memory[~between])
    run.next()
    run.next()
    assert run.state.n_idle_generations[~between].tolist() == [0, 0]
    assert np.array_equal(run.state.weights[~between], first[~between])
    assert not (run.state.incumbents[~between] == memory[~between]).any()
    assert np.isinf(run.state.incumbent_F[~between]).all()
    assert np.isinf(run.state.incumbent_violation[~between]).all()


class Creep(Problem):
    """Feasible nowhere: the violation is the distance from a far corner."""

    def __init__(self):
        super().__init__(n_var=3, n_obj=2, n_ieq_constr=1, xl=0.0, xu=1.0)

    def _evaluate(self, X, out, *args, **kwargs):
        out["F"] = X[:, :2]
        out["G"] = 4.0 - X.sum(axis=1)


def test_less_violation_is_progress():
    run = begun(
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
        assert (run.state.n_idle_generations == 0).all()  # progress, or a restart
        assert (less | np.isinf(run.state.incumbent_violation)).all()
    assert np.isinf(run.state.incumbent_violation).any()


def test_constraints_come_first():
    problem = BNH()
    result = minimize(problem, MGEODirected(n_walkers=8), ("n_gen", 150), seed=1)
    assert np.all(result.CV == 0)
    area = HV(ref_point=np.array([140.0, 50.0]))
    assert area(result.F) > 0.995 * area(problem.pareto_front())
