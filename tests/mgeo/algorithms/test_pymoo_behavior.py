"""Everything a built-in pymoo algorithm does, MGEOReal does too."""

import copy

import numpy as np
import pytest
from pymoo.constraints.as_penalty import ConstraintsAsPenalty
from pymoo.core.evaluator import Evaluator
from pymoo.core.population import Population
from pymoo.indicators.hv import HV
from pymoo.optimize import minimize
from pymoo.problems.dyn import TimeSimulation
from pymoo.problems.dynamic.df import DF1
from pymoo.problems.multi import BNH, ZDT1

from mgeo import EvaluationError, MGEOCanonical, MGEODirected, MGEOReal, MGEOStaged, ParetoArchive

from .problems import Arc, Estimated, Fixed, Mixture, Typed

PROBLEM = ZDT1(n_var=5)
SMALL = MGEOReal(0.2, n_walkers=4)


def solve(problem=PROBLEM, algorithm=SMALL, n_gen=10, **options):
    return minimize(problem, algorithm, ("n_gen", n_gen), **{"seed": 1, **options})


def same(a, b):
    return np.array_equal(a.X, b.X) and np.array_equal(a.F, b.F)


@pytest.mark.parametrize(("n_walkers", "generations"), [(1, 5000), (1000, 5)])
def test_default_budget_is_5000_generations_shared_by_the_walkers(n_walkers, generations):
    algorithm = MGEOReal(n_walkers=n_walkers).setup(PROBLEM)
    assert algorithm.termination.n_max_gen == generations


@pytest.mark.parametrize("evaluations", [20, 100])
def test_a_budget_of_whole_generations_is_met_exactly(evaluations):
    result = minimize(PROBLEM, SMALL, ("n_eval", evaluations), seed=1)
    assert result.algorithm.evaluator.n_eval == evaluations


def test_result_is_the_archive_of_every_point_evaluated():
    seen = []
    result = solve(callback=lambda algorithm: seen.append(algorithm.pop.get("F")))
    archive = ParetoArchive(2)
    for F in seen:
        archive.add(F, np.empty(len(F), dtype=object))
    assert np.array_equal(result.F, archive.F)
    assert result.opt is result.algorithm.front.individuals
    assert isinstance(result.opt, Population)
    assert np.array_equal(result.pop.get("F"), seen[-1])
    assert result.opt.get("n_gen").max() <= 10


def test_seed_none_draws_afresh_and_same_object_runs_twice():
    assert same(solve(seed=3), solve(seed=3))
    assert not same(solve(seed=None), solve(seed=None))
    assert not same(solve(seed=3), solve(seed=4))
    assert SMALL.problem is None


@pytest.mark.parametrize("algorithm", [MGEOReal(n_walkers=4), MGEODirected(n_walkers=4)])
@pytest.mark.parametrize("asked", [False, True])
def test_a_second_setup_of_a_used_algorithm_is_refused(algorithm, asked):
    run = copy.deepcopy(algorithm).setup(PROBLEM, termination=("n_gen", 3), seed=1)
    run.setup(PROBLEM, termination=("n_gen", 3), seed=1)  # not used yet
    first = run.ask() if asked else run.run()
    used = rf"this {type(algorithm).__name__} has already started a run: expected a new "
    with pytest.raises(RuntimeError, match=used):
        run.setup(PROBLEM, termination=("n_gen", 3), seed=1)
    if asked:  # the run that it has begun goes on
        run.evaluator.eval(PROBLEM, first)
        run.tell(infills=first)
        first = run.run()
    assert same(first, solve(algorithm=algorithm, n_gen=3))


@pytest.mark.parametrize("algorithm", [SMALL, MGEODirected(), MGEOCanonical(n_walkers=2)])
@pytest.mark.parametrize(
    "problem",
    [DF1(taut=2, n_var=2), ConstraintsAsPenalty(DF1(taut=2, n_var=2))],
    ids=["problem", "wrapped"],
)
def test_dynamic_problems_are_refused(algorithm, problem):
    with pytest.raises(
        ValueError, match=r"is a dynamic problem, .* would keep outdated objectives"
    ):
        solve(problem, algorithm, callback=TimeSimulation())


@pytest.mark.parametrize(
    "algorithm",
    [MGEOReal(0.2, n_walkers=4), MGEODirected(n_walkers=4), MGEOCanonical(n_walkers=4, bits=10)],
    ids=lambda algorithm: type(algorithm).__name__,
)
def test_fewer_starting_points_than_walkers_leave_the_others_as_they_were(algorithm):
    X = np.random.default_rng(1).integers(0, 1024, (4, 5)) / 1023
    placed = {}
    for n, sampling in {0: None, 1: X[:1].tolist(), 3: Population.new(X=X[:3]), 4: X}.items():
        run = copy.deepcopy(algorithm)
        run.sampling = sampling
        placed[n] = run.setup(PROBLEM, seed=1).encoding.decode(run.walkers)
        assert placed[n][:n] == pytest.approx(X[:n], rel=1e-12)
    for n in (1, 3):
        assert np.array_equal(placed[n][n:], placed[0][n:])
    assert not np.isclose(placed[0], X).any()


def test_tell_refuses_other_candidates():
    algorithm = copy.deepcopy(SMALL).setup(PROBLEM, seed=1)
    with pytest.raises(ValueError, match=r"expected the candidates of the last ask\(\)"):
        algorithm.tell(infills=Population.new(X=np.zeros((20, 5))))
    infills = algorithm.ask()
    with pytest.raises(ValueError, match=r"F of shape \(20, 0\): .*every candidate evaluated"):
        algorithm.tell(infills=infills)
    algorithm.evaluator.eval(PROBLEM, infills)
    twice = infills[[0, *range(len(infills) - 1)]]
    for other in (infills[:7], twice, None):
        with pytest.raises(ValueError, match="unchanged, each once, in any order"):
            algorithm.tell(infills=other)
    algorithm.tell(infills=infills)
    with pytest.raises(ValueError, match=r"the last ask\(\)"):
        algorithm.tell(infills=infills)


@pytest.mark.parametrize(
    ("algorithm", "problem"),
    [
        (SMALL, PROBLEM),
        (MGEODirected(n_walkers=4), PROBLEM),
        (MGEOCanonical(n_walkers=3, bits=2), PROBLEM),  # with equal candidates
        (MGEODirected(n_walkers=4), Typed()),
        (MGEOStaged(n_walkers=4, fidelity_schedule=(0.3, 0.6)), Estimated()),
    ],
    ids=lambda value: type(value).__name__,
)
def test_candidates_may_be_told_in_another_order(algorithm, problem):
    rng = np.random.default_rng(7)
    run = copy.deepcopy(algorithm).setup(problem, termination=("n_gen", 10), seed=1)
    while run.has_next():
        asked = run.ask()
        shuffled = Population.new(X=asked.get("X")[rng.permutation(len(asked))])
        Evaluator().eval(run.problem, shuffled)
        run.tell(infills=shuffled)
    assert same(run.result(), solve(problem, algorithm))


def test_constraints_are_met_and_the_front_approaches_the_known_one():
    problem = BNH()
    result = minimize(problem, MGEOReal(0.5, 1.0, 20), ("n_gen", 100), seed=1)
    assert np.all(result.CV == 0)
    assert np.all(problem.evaluate(result.X, return_values_of=["G"]) <= 0)
    # BNH's set is x2 = x1 up to 3, then x2 = 3 with x1 up to 5
    x1, x2 = result.X.T
    assert np.abs(x2 - np.minimum(x1, 3.0)).max() < 0.6
    assert np.diff(np.sort(result.F[:, 0])).max() < 5.0


def test_equality_constraints_count():
    result = minimize(Mixture(), MGEOReal(1.0, n_walkers=5), ("n_gen", 50), seed=1)
    assert np.all(np.abs(result.H) <= 1e-4)
    assert np.all(result.G <= 0)
    assert np.isfinite(result.F).all()
    assert result.algorithm.front.n_rejected > 0


def test_the_default_search_leaves_the_corners_that_satisfy_an_equality():
    """Both ends of the arc are corners of the bounds; its area is a quarter of a circle."""
    area = HV(ref_point=np.zeros(2))

    def found(**options):
        runs = (
            minimize(Arc(), MGEODirected(**options), ("n_eval", 1000), seed=seed)
            for seed in (1, 4, 6)
        )
        return np.median([area(run.F) for run in runs])

    assert found() > np.pi / 16
    assert found(bounds="clip") < np.pi / 64


@pytest.mark.parametrize("problem", [PROBLEM, BNH()], ids=["free", "inequalities"])
def test_steps_are_clipped_by_default_without_equalities(problem):
    clipped = solve(problem, MGEODirected(bounds="clip"))
    assert same(solve(problem, MGEODirected()), clipped)


def test_evaluations_that_all_fail_leave_no_result():
    with pytest.raises(EvaluationError, match=r"candidates failed, the first with F\[0\] = nan"):
        solve(Fixed([np.nan, 1.0]))
    result = solve(Fixed([np.nan, 1.0]), evaluator=Evaluator())
    assert result.X is None
    assert result.F is None
    assert result.algorithm.front.n_rejected == 10 * 4 * 3
