"""`mgeo.compare`: what is run, what is measured, and what is refused."""

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
    FailingNSGA2,
    GlobalRandomSearch,
    Half,
    OwnNoise,
    Remembering,
    StuckSearch,
    Wearing,
)

PROBLEM = ZDT1(n_var=4)
ALGORITHMS = {
    "MGEO": MGEOReal(sigma=0.3, n_walkers=3, perturbation="range"),
    "NSGA-II": NSGA2(pop_size=12),
    "C-MOPSO": CMOPSO(pop_size=12),
    "RVEA": RVEA(get_reference_directions("das-dennis", 2, n_partitions=11)),
}


@pytest.fixture(scope="module")
def serial():
    return compare(PROBLEM, ALGORITHMS, 150, seeds=3, grid=[50, 77])


def test_the_table_is_tidy_and_complete(serial):
    assert mgeo.compare is compare
    assert list(serial.table.columns[:3]) == ["algorithm", "seed", "evaluations"]
    keys = serial.table[["algorithm", "seed", "evaluations"]].to_numpy().tolist()
    assert keys == [[a, s, n] for a in ALGORITHMS for s in (1, 2, 3) for n in (50, 77, 150)]
    assert not serial.table.isna().any(axis=None)
    assert serial.runs["status"].tolist() == ["finished"] * 12


def test_every_algorithm_is_measured_by_all_its_evaluations(serial):
    """An independent count of RVEA's evaluations, which RVEA's own result does not hold."""
    evaluated = []
    problem = ZDT1(n_var=4)
    problem.callback = lambda X, out: evaluated.append(out["F"].copy())
    minimize(problem, ALGORITHMS["RVEA"], ("n_eval", 180), seed=2)
    F = np.concatenate(evaluated)
    for n in (50, 77, 150):
        front = F[:n][nondominated_rows(F[:n])]
        row = serial.table.query("algorithm == 'RVEA' and seed == 2 and evaluations == @n").iloc[0]
        assert row["points"] == len(front)
        if n == 150:
            assert row["hypervolume"] == pytest.approx(
                HV(ref_point=serial.space.reference_point)(serial.space(front))
            )


def test_fronts_satisfy_an_equality():
    found = compare(Arc(), {"directed": MGEODirected()}, 300, seeds=1, grid=2)
    (F,) = found.list_fronts("directed")
    assert len(F)
    assert np.abs((F**2).sum(axis=1) - 1.0).max() <= 1e-4


def test_processes_give_the_same_table(serial):
    parallel = compare(PROBLEM, ALGORITHMS, 150, seeds=3, grid=[50, 77], n_jobs=2)
    assert parallel.table.equals(serial.table)


@pytest.mark.parametrize(
    ("make", "n_jobs"), [(Wearing, 1), (OwnNoise, 1), (Remembering, 1), (Remembering, 2)]
)
def test_each_run_has_its_own_copy_of_the_problem(make, n_jobs):
    problem = make()
    before = pickle.dumps(problem)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ComparisonWarning)
        found = compare(problem, {"a": NSGA2(12), "b": NSGA2(12)}, 60, seeds=2, n_jobs=n_jobs)
    assert pickle.dumps(problem) == before
    for seed in (1, 2):
        alone = record_run(Task(make(), NSGA2(12), 60, seed))
        for label in ("a", "b"):
            assert np.array_equal(found.finished_runs[label, seed].front_F, alone.front_F)


def used(algorithm):
    minimize(ZDT1(n_var=4), algorithm, ("n_eval", 24), copy_algorithm=False)
    return algorithm


@pytest.mark.parametrize(
    "make",
    [
        lambda: NSGA2(12).setup(PROBLEM, termination=("n_eval", 24), seed=1),
        lambda: used(GlobalRandomSearch()),
        lambda: used(MGEOReal(0.1, n_walkers=2)),
    ],
    ids=["set up", "used", "of the family"],
)
def test_an_algorithm_that_is_set_up_or_has_run_is_refused(make):
    with pytest.raises(ValueError, match=r"algorithms\['a'\] is set up or has run"):
        compare(PROBLEM, {"a": make()}, 40, seeds=1)


def test_a_run_that_fails_is_reported_and_the_rest_completes(tmp_path, capsys):
    algorithms = {"good": NSGA2(pop_size=12), "bad": FailingNSGA2(pop_size=12)}
    result = compare(PROBLEM, algorithms, 40, seeds=4, progress=True)
    failed = result.runs[result.runs["status"] == "failed"]
    assert failed[["algorithm", "seed"]].to_numpy().tolist() == [["bad", 2], ["bad", 4]]
    assert failed["error"].tolist() == [f"ArithmeticError: seed {s} is even" for s in (2, 4)]
    assert result.select_final_rows().groupby("algorithm").size().to_dict() == {"bad": 2, "good": 4}
    lines = capsys.readouterr().err.splitlines()
    assert lines == [f"ZDT1: bad, seed {s}: ArithmeticError: seed {s} is even" for s in (2, 4)]


def test_an_algorithm_that_failed_everywhere_is_named_in_a_warning():
    algorithms = {"good": NSGA2(pop_size=12), "bad": FailingNSGA2()}
    message = "^bad on ZDT1: 2 of 2 runs failed, the first with ArithmeticError: seed 2 is even$"
    with pytest.warns(FailedRunsWarning, match=message) as caught:
        compare(PROBLEM, algorithms, 40, seeds=[2, 4])
    assert [warning.filename for warning in caught] == [__file__]


def test_an_algorithm_without_new_candidates_fails():
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


def test_infeasible_and_undefined_points_count_but_are_no_front():
    result = compare(Half(), [NSGA2(pop_size=10)], 100, seeds=2, grid=[1, 100])
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
def test_bad_arguments_are_refused(arguments, options, message):
    with pytest.raises((ValueError, TypeError), match=message):
        compare(PROBLEM, *arguments, **options)


class Offset(Sphere):
    """Least value -3, and infeasible where the first variable is small."""

    def __init__(self):
        super().__init__(n_var=3)
        self.n_ieq_constr = 1

    def _evaluate(self, X, out, *args, **kwargs):
        super()._evaluate(X, out, *args, **kwargs)
        out["F"], out["G"] = out["F"] - 3.0, 0.3 - X[:, :1]


@pytest.mark.slow
def test_with_one_objective_the_best_value_counts():
    algorithms = {
        "GEO": MGEOReal(sigma=0.1, n_walkers=3, perturbation="range"),
        "GA": GA(pop_size=12),
        "random": RandomSearch(n_points_per_iteration=12),
    }
    found = compare(Offset(), algorithms, 240, seeds=4, grid=[1, 120])
    assert [i.name for i in found.indicators] == ["best_value"]
    for name, seed in found.finished_runs:
        values = []
        problem = Offset()
        problem.callback = lambda X, out, into=values: into.extend(
            np.where(out["G"] <= 0, out["F"], np.inf)[:, 0]
        )
        minimize(problem, algorithms[name], ("n_eval", 240), seed=seed)
        rows = found.table[(found.table["algorithm"] == name) & (found.table["seed"] == seed)]
        assert rows["best_value"].tolist() == [min(values[:n]) for n in (1, 120, 240)]
        assert rows["points"].tolist() == np.isfinite(rows["best_value"]).astype(int).tolist()
    assert np.isinf(found.table["best_value"]).any()  # nothing feasible at first
    medians = found.summarize()[("best_value", "median")]
    assert -3.0 < medians.min() < -2.8
    assert found.rank_algorithms()[0] == medians.idxmin()
    assert list(found.draw_figures()) == ["anytime", "boxes"]
    assert len(format_conclusions(found)) == 2
    assert len(found.test_differences().pairs) == 3
