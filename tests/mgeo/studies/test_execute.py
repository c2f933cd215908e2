import pickle
import random
import warnings

import numpy as np
import pytest
from pymoo.algorithms.moo.cmopso import CMOPSO
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.algorithms.moo.rvea import RVEA
from pymoo.algorithms.soo.nonconvex.ga import GA
from pymoo.algorithms.soo.nonconvex.random_search import RandomSearch
from pymoo.indicators.hv import HV
from pymoo.optimize import minimize
from pymoo.problems.multi import ZDT1
from pymoo.problems.single import Sphere
from pymoo.util.ref_dirs import get_reference_directions

import mgeo
from mgeo import MGEODirected, MGEOReal, compare
from mgeo.studies.comparison import ComparisonWarning, FailedRunsWarning
from mgeo.studies.conclusions import format_conclusions
from mgeo.studies.run import Task, record_run

from ..algorithms.problems import Arc
from ..naive import nondominated_rows
from .problems import (
    DriftingProblem,
    FailingNSGA2,
    GlobalRandomSearch,
    HalfFeasibleProblem,
    NoisyProblem,
    StuckSearch,
    SurrogateProblem,
)

PROBLEM = ZDT1(n_var=4)
ALGORITHMS = {
    "MGEO": MGEOReal(sigma=0.3, n_walkers=3, perturbation="range"),
    "NSGA-II": NSGA2(pop_size=12),
    "C-MOPSO": CMOPSO(pop_size=12),
    "RVEA": RVEA(get_reference_directions("das-dennis", 2, n_partitions=11)),
}


@pytest.fixture(scope="module")
def serial_result():
    return compare(PROBLEM, ALGORITHMS, 150, seeds=3, grid=[50, 77])


def test_table_has_one_row_per_algorithm_seed_and_count(serial_result):
    assert mgeo.compare is compare
    assert list(serial_result.table.columns[:3]) == ["algorithm", "seed", "evaluations"]
    keys = serial_result.table[["algorithm", "seed", "evaluations"]].to_numpy().tolist()
    assert keys == [[a, s, n] for a in ALGORITHMS for s in (1, 2, 3) for n in (50, 77, 150)]
    assert not serial_result.table.isna().any(axis=None)
    assert serial_result.runs["status"].tolist() == ["finished"] * 12


def test_front_is_computed_from_all_evaluations(serial_result):
    """RVEA discards points of its front; pymoo's evaluation callback counts all of them."""
    evaluated = []
    problem = ZDT1(n_var=4)
    problem.callback = lambda X, out: evaluated.append(out["F"].copy())
    minimize(problem, ALGORITHMS["RVEA"], ("n_eval", 180), seed=2)
    F = np.concatenate(evaluated)
    for n in (50, 77, 150):
        front = F[:n][nondominated_rows(F[:n])]
        row = serial_result.table.query(
            "algorithm == 'RVEA' and seed == 2 and evaluations == @n"
        ).iloc[0]
        assert row["points"] == len(front)
        if n == 150:
            assert row["hypervolume"] == pytest.approx(
                HV(ref_point=serial_result.space.reference_point)(serial_result.space(front))
            )


def test_fronts_satisfy_equality_constraint():
    result = compare(Arc(), {"directed": MGEODirected()}, 300, seeds=1, grid=2)
    (F,) = result.list_fronts("directed")
    assert len(F)
    assert np.abs((F**2).sum(axis=1) - 1.0).max() <= 1e-4


def test_table_does_not_depend_on_number_of_processes(serial_result):
    parallel = compare(PROBLEM, ALGORITHMS, 150, seeds=3, grid=[50, 77], n_jobs=2)
    assert parallel.table.equals(serial_result.table)


@pytest.mark.parametrize(
    ("make", "n_jobs"),
    [(DriftingProblem, 1), (NoisyProblem, 1), (SurrogateProblem, 1), (SurrogateProblem, 2)],
)
def test_each_run_has_its_own_copy_of_the_problem(make, n_jobs):
    problem = make()
    before = pickle.dumps(problem)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ComparisonWarning)
        result = compare(problem, {"a": NSGA2(12), "b": NSGA2(12)}, 60, seeds=2, n_jobs=n_jobs)
    assert pickle.dumps(problem) == before
    for seed in (1, 2):
        expected = record_run(Task(make(), NSGA2(12), 60, seed))
        for label in ("a", "b"):
            assert np.array_equal(result.finished_runs[label, seed].front_F, expected.front_F)


def run_algorithm(algorithm):
    minimize(ZDT1(n_var=4), algorithm, ("n_eval", 24), copy_algorithm=False)
    return algorithm


@pytest.mark.parametrize(
    "make",
    [
        lambda: NSGA2(12).setup(PROBLEM, termination=("n_eval", 24), seed=1),
        lambda: run_algorithm(GlobalRandomSearch()),
        lambda: run_algorithm(MGEOReal(0.1, n_walkers=2)),
    ],
    ids=["set up", "has run", "MGEO that has run"],
)
def test_algorithm_that_is_set_up_or_has_run_is_rejected(make):
    with pytest.raises(ValueError, match=r"algorithms\['a'\] is set up or has run"):
        compare(PROBLEM, {"a": make()}, 40, seeds=1)


def test_failed_run_is_reported_and_other_runs_complete(tmp_path, capsys):
    algorithms = {"good": NSGA2(pop_size=12), "bad": FailingNSGA2(pop_size=12)}
    result = compare(PROBLEM, algorithms, 40, seeds=4, progress=True)
    failed = result.runs[result.runs["status"] == "failed"]
    assert failed[["algorithm", "seed"]].to_numpy().tolist() == [["bad", 2], ["bad", 4]]
    assert failed["error"].tolist() == [f"ArithmeticError: seed {s} is even" for s in (2, 4)]
    assert result.select_final_rows().groupby("algorithm").size().to_dict() == {"bad": 2, "good": 4}
    lines = capsys.readouterr().err.splitlines()
    assert lines == [f"ZDT1: bad, seed {s}: ArithmeticError: seed {s} is even" for s in (2, 4)]


def test_warning_names_algorithm_whose_runs_all_failed():
    algorithms = {"good": NSGA2(pop_size=12), "bad": FailingNSGA2()}
    message = "^bad on ZDT1: 2 of 2 runs failed, the first with ArithmeticError: seed 2 is even$"
    with pytest.warns(FailedRunsWarning, match=message) as caught:
        compare(PROBLEM, algorithms, 40, seeds=[2, 4])
    assert [warning.filename for warning in caught] == [__file__]


def test_algorithm_without_new_candidates_raises_error():
    with pytest.raises(RuntimeError, match="StuckSearch proposed no new candidate after 7 of 40"):
        record_run(Task(PROBLEM, StuckSearch(), 40, 1))


def test_global_random_state_is_seeded_and_restored():
    np.random.seed(5)  # noqa: NPY002
    random.seed(5)
    expected = np.random.random(), random.random()  # noqa: NPY002
    np.random.seed(5)  # noqa: NPY002
    random.seed(5)
    runs = [record_run(Task(PROBLEM, GlobalRandomSearch(), 60, seed)) for seed in (1, 1, 2)]
    assert (np.random.random(), random.random()) == expected  # noqa: NPY002
    assert np.array_equal(runs[0].F, runs[1].F)
    assert not np.array_equal(runs[0].F, runs[2].F)


def test_infeasible_and_nan_points_count_but_are_not_in_fronts():
    result = compare(HalfFeasibleProblem(), [NSGA2(pop_size=10)], 100, seeds=2, grid=[1, 100])
    for run in result.finished_runs.values():
        assert run.n_failed > 0
        assert (run.X[:, 0] >= 0.5).all()
        assert not ((run.X[:, 0] > 0.6) & (run.X[:, 0] < 0.7)).any()
        assert np.isfinite(run.front_F).all()
    assert (
        result.runs["failed_evaluations"] == [r.n_failed for r in result.finished_runs.values()]
    ).all()


@pytest.mark.parametrize(
    ("arguments", "options", "message"),
    [
        (([], 10), {}, "at least one"),
        (([NSGA2(), NSGA2()], 10), {}, "expected labels"),
        (([NSGA2()], 0), {}, "n_eval = 0"),
        (([NSGA2()], 10, [1, 1]), {}, "different"),
        (([NSGA2()], 10), {"grid": [11]}, "grid contains 11: expected at most n_eval = 10"),
        (([NSGA2()], 10), {"parts": [2.0, 1.0]}, "expected one or more ascending values"),
        (([NSGA2()], 10), {"resume": True}, "resume = True without folder"),
    ],
)
def test_invalid_arguments_are_rejected(arguments, options, message):
    with pytest.raises((ValueError, TypeError), match=message):
        compare(PROBLEM, *arguments, **options)


class ShiftedSphere(Sphere):
    """Problem with the minimum -3 that is infeasible for small values of the first variable."""

    def __init__(self):
        super().__init__(n_var=3)
        self.n_ieq_constr = 1

    def _evaluate(self, X, out, *args, **kwargs):
        super()._evaluate(X, out, *args, **kwargs)
        out["F"], out["G"] = out["F"] - 3.0, 0.3 - X[:, :1]


@pytest.mark.slow
def test_single_objective_is_compared_by_best_value():
    algorithms = {
        "GEO": MGEOReal(sigma=0.1, n_walkers=3, perturbation="range"),
        "GA": GA(pop_size=12),
        "random": RandomSearch(n_points_per_iteration=12),
    }
    result = compare(ShiftedSphere(), algorithms, 240, seeds=4, grid=[1, 120])
    assert [i.name for i in result.indicators] == ["best_value"]
    for name, seed in result.finished_runs:
        values = []
        problem = ShiftedSphere()
        problem.callback = lambda X, out, into=values: into.extend(
            np.where(out["G"] <= 0, out["F"], np.inf)[:, 0]
        )
        minimize(problem, algorithms[name], ("n_eval", 240), seed=seed)
        rows = result.table[(result.table["algorithm"] == name) & (result.table["seed"] == seed)]
        assert rows["best_value"].tolist() == [min(values[:n]) for n in (1, 120, 240)]
        assert rows["points"].tolist() == np.isfinite(rows["best_value"]).astype(int).tolist()
    assert np.isinf(result.table["best_value"]).any()  # The first points are infeasible.
    medians = result.summarize()[("best_value", "median")]
    assert -3.0 < medians.min() < -2.8
    assert result.rank_algorithms()[0] == medians.idxmin()
    assert list(result.draw_figures()) == ["anytime", "boxes"]
    assert len(format_conclusions(result)) == 2
    assert len(result.test_differences().pairs) == 3
