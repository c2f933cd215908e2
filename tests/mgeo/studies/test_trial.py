import os
import time

import numpy as np
import pytest
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.algorithms.soo.nonconvex.ga import GA, FitnessSurvival
from pymoo.constraints.as_penalty import ConstraintsAsPenalty
from pymoo.core.population import Population
from pymoo.core.problem import ElementwiseProblem, Problem
from pymoo.operators.crossover.sbx import SBX
from pymoo.operators.mutation.pm import PM
from pymoo.operators.repair.rounding import RoundingRepair
from pymoo.operators.sampling.rnd import IntegerRandomSampling
from pymoo.problems.dyn import TimeSimulation
from pymoo.problems.dynamic.df import DF1
from pymoo.problems.multi import BNH, ZDT1

from mgeo import MGEOCanonical, MGEODirected, MGEOReal, MGEOStaged, compare
from mgeo.studies import ComparisonWarning, read_comparison

from .problems import DriftingProblem, GlobalRandomSearch, NoisyProblem


class Sphere(Problem):
    """Problem of one objective with a constraint, as in pymoo's issues 794 and 795."""

    def __init__(self):
        super().__init__(n_var=5, n_obj=1, n_ieq_constr=1, xl=-5, xu=5)

    def _evaluate(self, X, out, *args, **kwargs):
        out["F"] = ((X - 4.9) ** 2).sum(axis=1)
        out["G"] = np.ceil(X[:, 0] - 4.0)


class GlobalNoise(ZDT1):
    def _evaluate(self, X, out, *args, **kwargs):
        super()._evaluate(X, out, *args, **kwargs)
        out["F"] *= np.random.normal(1.0, 0.1, (len(X), 1))  # noqa: NPY002


class NoisyConstraint(BNH):
    def _evaluate(self, x, out, *args, **kwargs):
        super()._evaluate(x, out, *args, **kwargs)
        out["G"] = out["G"] + np.random.default_rng().normal(size=out["G"].shape)


class NoisyElement(ElementwiseProblem):
    def __init__(self):
        super().__init__(n_var=2, n_obj=2, xl=0.0, xu=1.0)

    def _evaluate(self, x, out, *args, **kwargs):
        out["F"] = [x[0] + os.urandom(1)[0], 1.0 - x[1]]


class ShiftedByCallback(ZDT1):
    """Problem that a callback changes, and that is not one of pymoo's dynamic problems."""

    shift = 0.0

    def _evaluate(self, X, out, *args, **kwargs):
        super()._evaluate(X, out, *args, **kwargs)
        out["F"] = out["F"] + self.shift


def shift_problem(algorithm):
    algorithm.problem.shift += 1.0


def compare_with_notes(problem, algorithms, n_eval=60, seeds=1, **options):
    with pytest.warns(ComparisonWarning) as caught:
        result = compare(problem, algorithms, n_eval, seeds, grid=1, progress=False, **options)
    assert [str(warning.message) for warning in caught] == list(result.notes)
    return result


@pytest.mark.parametrize(
    ("problem", "algorithm"),
    [
        (NoisyProblem(), NSGA2(12)),
        (GlobalNoise(n_var=4), NSGA2(12)),
        (NoisyConstraint(), NSGA2(12)),
        (NoisyElement(), MGEOReal(0.1, n_walkers=3)),
        (DriftingProblem(), NSGA2(12)),
        (ShiftedByCallback(n_var=4), NSGA2(12, callback=shift_problem)),
    ],
)
def test_noisy_problem_is_noted(problem, algorithm):
    (note,) = compare_with_notes(problem, [algorithm]).notes
    assert note.startswith(f"{type(problem).__name__} is noisy: ")


@pytest.mark.parametrize(
    ("problem", "algorithms"),
    [
        (ZDT1(n_var=4), [NSGA2(12), MGEOReal(0.1, n_walkers=3), MGEODirected()]),
        (ZDT1(n_var=4), [GlobalRandomSearch()]),
        (Sphere(), [GA(12)]),
    ],
)
def test_reproducible_comparison_has_no_notes(problem, algorithms):
    assert compare(problem, algorithms, 200, 1, grid=1, progress=False).notes == ()


class CountingProblem(ZDT1):
    """Problem that counts its evaluations at all fidelity levels."""

    evaluated = 0

    def _evaluate(self, X, out, *args, **kwargs):
        super()._evaluate(X, out, *args, **kwargs)
        CountingProblem.evaluated += len(X)

    def at_fidelity(self, fidelity):
        return self if fidelity == 2 else CountingProblem(n_var=4)


@pytest.mark.parametrize("algorithm", [NSGA2(20), MGEOStaged(n_walkers=4)])
def test_trial_runs_make_six_evaluations_of_the_problem(algorithm):
    CountingProblem.evaluated = 0
    result = compare(
        CountingProblem(n_var=4), [algorithm], 200, 1, grid=1, n_jobs=1, progress=False
    )
    (record,) = result.finished_runs.values()
    assert CountingProblem.evaluated == record.n_evaluations + 6


class EntropySearch(GlobalRandomSearch):
    def _infill(self):
        return Population.new("X", np.random.default_rng().random((20, self.problem.n_var)))


class CountingSearch(GlobalRandomSearch):
    """Search whose state is in the class, so that copies share it."""

    generations = 0

    def _infill(self):
        CountingSearch.generations += 1
        random_state = np.random.default_rng(CountingSearch.generations)
        return Population.new("X", random_state.random((20, self.problem.n_var)))


class ClockSearch(GlobalRandomSearch):
    def _infill(self):
        random_state = np.random.default_rng(time.perf_counter_ns())
        return Population.new("X", random_state.random((20, self.problem.n_var)))


class UnseededTieBreaking(FitnessSurvival):
    """Selection by fitness that orders equal values at random, without a seed."""

    def _do(self, problem, pop, *args, n_survive=None, **kwargs):
        order = np.lexsort((np.random.default_rng().random(len(pop)), pop.get("F")[:, 0]))
        return pop[order][:n_survive]


@pytest.mark.usefixtures("without_figures")
def test_runs_of_irreproducible_algorithm_are_not_reused(tmp_path, capsys):
    problem, algorithms = ZDT1(n_var=4), {"own": EntropySearch(), "NSGA-II": NSGA2(12)}
    (note,) = compare_with_notes(problem, algorithms, folder=tmp_path).notes
    assert "two runs of own with the same seed differ" in note
    stored = {path: path.stat().st_mtime_ns for path in (tmp_path / "runs").iterdir()}
    with pytest.warns(ComparisonWarning, match="none is reused"):
        compare(problem, algorithms, 60, seeds=1, grid=1, resume=True, folder=tmp_path)
    assert "reused 1 of 2 runs" in capsys.readouterr().err
    repeated = {path.name for path, before in stored.items() if path.stat().st_mtime_ns != before}
    assert repeated == {"own-seed1.npz"}
    assert read_comparison(tmp_path, problem=problem).notes == (note,)


@pytest.mark.cases(3)
@pytest.mark.parametrize(
    ("problem", "algorithm", "n_eval"),
    [
        (ZDT1(n_var=4), CountingSearch(), 60),
        (ZDT1(n_var=4), ClockSearch(), 60),
        (Sphere(), GA(50, survival=UnseededTieBreaking()), 200),
    ],
    ids=lambda value: type(value).__name__,
)
def test_irreproducible_algorithm_is_noted(problem, algorithm, n_eval):
    (note,) = compare_with_notes(problem, {"own": algorithm}, n_eval).notes
    assert "two runs of own with the same seed differ" in note


@pytest.mark.parametrize(
    "problem",
    [DF1(taut=2, n_var=3), ConstraintsAsPenalty(DF1(taut=2, n_var=3))],
    ids=["problem", "wrapped"],
)
@pytest.mark.parametrize("algorithm", [NSGA2(12, callback=TimeSimulation()), MGEODirected()])
def test_dynamic_problems_are_rejected(problem, algorithm):
    with pytest.raises(ValueError, match=r"is a dynamic problem: .* one problem for each time"):
        compare(problem, [algorithm], 60, 1)


def test_first_generation_beyond_budget_is_noted():
    (note,) = compare_with_notes(
        ZDT1(n_var=3), [MGEOCanonical(n_walkers=5, bits=12)], n_eval=100
    ).notes
    assert "first generation of MGEOCanonical has 180 evaluations, of which only the" in note
    (note,) = compare_with_notes(ZDT1(n_var=3), {"large": NSGA2(112)}, n_eval=100).notes
    assert "first generation of large has 112 evaluations, of which only the first 100" in note
    assert compare(ZDT1(n_var=3), [NSGA2(110)], 100, 1, grid=1, progress=False).notes == ()


class IntegerSums(Problem):
    def __init__(self):
        super().__init__(n_var=3, n_obj=2, xl=0, xu=9, vtype=int)

    def _evaluate(self, X, out, *args, **kwargs):
        X = X.astype(float)
        out["F"] = np.column_stack([X.sum(axis=1), ((X - 9.0) ** 2).sum(axis=1)])


def test_fractional_values_of_integer_variables_are_rejected():
    message = r"IntegerSums has integer variables, but NSGA2 evaluates \d\.\d+"
    with pytest.raises(ValueError, match=message):
        compare(IntegerSums(), {"NSGA2": NSGA2(pop_size=8)}, n_eval=60, seeds=1)


def test_integer_operators_of_pymoo_are_accepted():
    algorithm = NSGA2(
        pop_size=8,
        sampling=IntegerRandomSampling(),
        crossover=SBX(vtype=float, repair=RoundingRepair()),
        mutation=PM(vtype=float, repair=RoundingRepair()),
    )
    result = compare(IntegerSums(), {"NSGA2": algorithm}, n_eval=60, seeds=1)
    assert (result.finished_runs["NSGA2", 1].X % 1 == 0).all()
