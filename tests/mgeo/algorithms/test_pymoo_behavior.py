"""Algorithms of mgeo behave as the built-in algorithms of pymoo."""

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


def is_same_result(a, b):
    return np.array_equal(a.X, b.X) and np.array_equal(a.F, b.F)


@pytest.mark.parametrize(("n_walkers", "generations"), [(1, 5000), (1000, 5)])
def test_default_budget_is_5000_generations_divided_by_walkers(n_walkers, generations):
    algorithm = MGEOReal(n_walkers=n_walkers).setup(PROBLEM)
    assert algorithm.termination.n_max_gen == generations


@pytest.mark.parametrize("evaluations", [20, 100])
def test_budget_of_whole_generations_is_met_exactly(evaluations):
    result = minimize(PROBLEM, SMALL, ("n_eval", evaluations), seed=1)
    assert result.algorithm.evaluator.n_eval == evaluations


def test_result_is_archive_of_all_evaluated_points():
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


def test_runs_repeat_with_seed_and_differ_without():
    assert is_same_result(solve(seed=3), solve(seed=3))
    assert not is_same_result(solve(seed=None), solve(seed=None))
    assert not is_same_result(solve(seed=3), solve(seed=4))
    assert SMALL.problem is None


@pytest.mark.parametrize("algorithm", [MGEOReal(n_walkers=4), MGEODirected(n_walkers=4)])
@pytest.mark.parametrize("asked", [False, True])
def test_second_setup_after_start_is_rejected(algorithm, asked):
    run = copy.deepcopy(algorithm).setup(PROBLEM, termination=("n_gen", 3), seed=1)
    run.setup(PROBLEM, termination=("n_gen", 3), seed=1)  # The run has not started yet.
    first = run.ask() if asked else run.run()
    used = rf"this {type(algorithm).__name__} has already started a run: expected a new "
    with pytest.raises(RuntimeError, match=used):
        run.setup(PROBLEM, termination=("n_gen", 3), seed=1)
    if asked:  # The started run continues.
        run.evaluator.eval(PROBLEM, first)
        run.tell(infills=first)
        first = run.run()
    assert is_same_result(first, solve(algorithm=algorithm, n_gen=3))


@pytest.mark.parametrize("algorithm", [SMALL, MGEODirected(), MGEOCanonical(n_walkers=2)])
@pytest.mark.parametrize(
    "problem",
    [DF1(taut=2, n_var=2), ConstraintsAsPenalty(DF1(taut=2, n_var=2))],
    ids=["problem", "wrapped"],
)
def test_dynamic_problems_are_rejected(algorithm, problem):
    with pytest.raises(
        ValueError, match=r"is a dynamic problem, .* would keep outdated objectives"
    ):
        solve(problem, algorithm, callback=TimeSimulation())


@pytest.mark.parametrize(
    "algorithm",
    [MGEOReal(0.2, n_walkers=4), MGEODirected(n_walkers=4), MGEOCanonical(n_walkers=4, bits=10)],
    ids=lambda algorithm: type(algorithm).__name__,
)
def test_remaining_walkers_do_not_depend_on_given_starting_points(algorithm):
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


def test_tell_rejects_other_candidates():
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
        (MGEOCanonical(n_walkers=3, bits=2), PROBLEM),  # Some candidates are equal.
        (MGEODirected(n_walkers=4), Typed()),
        (MGEOStaged(n_walkers=4, fidelity_schedule=(0.3, 0.6)), Estimated()),
    ],
    ids=lambda value: type(value).__name__,
)
def test_tell_accepts_candidates_in_any_order(algorithm, problem):
    rng = np.random.default_rng(7)
    run = copy.deepcopy(algorithm).setup(problem, termination=("n_gen", 10), seed=1)
    while run.has_next():
        asked = run.ask()
        shuffled = Population.new(X=asked.get("X")[rng.permutation(len(asked))])
        Evaluator().eval(run.problem, shuffled)
        run.tell(infills=shuffled)
    assert is_same_result(run.result(), solve(problem, algorithm))


def test_constraints_are_satisfied_and_front_approaches_known_front():
    problem = BNH()
    result = minimize(problem, MGEOReal(0.5, 1.0, 20), ("n_gen", 100), seed=1)
    assert np.all(result.CV == 0)
    assert np.all(problem.evaluate(result.X, return_values_of=["G"]) <= 0)
    # The Pareto set of BNH is x2 = x1 up to 3, and x2 = 3 with x1 up to 5.
    x1, x2 = result.X.T
    assert np.abs(x2 - np.minimum(x1, 3.0)).max() < 0.6
    assert np.diff(np.sort(result.F[:, 0])).max() < 5.0


def test_equality_constraints_are_satisfied():
    result = minimize(Mixture(), MGEOReal(1.0, n_walkers=5), ("n_gen", 50), seed=1)
    assert np.all(np.abs(result.H) <= 1e-4)
    assert np.all(result.G <= 0)
    assert np.isfinite(result.F).all()
    assert result.algorithm.front.n_rejected > 0


def test_default_bounds_let_search_leave_feasible_corners():
    # Both ends of the arc are corners of the bounds. Its hypervolume is a quarter of a circle.
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
def test_steps_are_clipped_by_default_without_equality_constraints(problem):
    clipped = solve(problem, MGEODirected(bounds="clip"))
    assert is_same_result(solve(problem, MGEODirected()), clipped)


def test_run_without_successful_evaluation_has_no_result():
    with pytest.raises(EvaluationError, match=r"candidates failed, the first with F\[0\] = nan"):
        solve(Fixed([np.nan, 1.0]))
    result = solve(Fixed([np.nan, 1.0]), evaluator=Evaluator())
    assert result.X is None
    assert result.F is None
    assert result.algorithm.front.n_rejected == 10 * 4 * 3
