import os
import platform
import random
import signal
import subprocess
import sys
import time
import weakref
from types import SimpleNamespace

import joblib
import numpy as np
import pytest
from pymoo.algorithms.moo.cmopso import CMOPSO
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.algorithms.moo.rvea import RVEA
from pymoo.algorithms.soo.nonconvex.ga import GA
from pymoo.algorithms.soo.nonconvex.random_search import RandomSearch
from pymoo.indicators.hv import HV
from pymoo.optimize import minimize
from pymoo.problems.functional import FunctionalProblem
from pymoo.problems.multi import ZDT1
from pymoo.problems.single import Sphere
from pymoo.util.ref_dirs import get_reference_directions

import mgeo
from mgeo import MGEOReal, compare
from mgeo.studies.conclusions import conclusions
from mgeo.studies.dispatch import run_all
from mgeo.studies.fingerprint.modules import distinct
from mgeo.studies.indicators import NothingToCompareError
from mgeo.studies.results import FailedRunsWarning
from mgeo.studies.run import Task, record

from ..naive import nondominated_rows
from .problems import DyingNSGA2, Element, FailingNSGA2, GlobalRandomSearch, Half, StuckSearch

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
    # what an independent count of RVEA's evaluations gives, which its own result does not hold
    evaluated = []
    problem = ZDT1(n_var=4)
    algorithm = ALGORITHMS["RVEA"]
    problem.callback = lambda X, out: evaluated.append(out["F"].copy())
    minimize(problem, algorithm, ("n_eval", 180), seed=2)
    F = np.concatenate(evaluated)
    for n in (50, 77, 150):
        front = F[:n][nondominated_rows(F[:n])]
        row = serial.table.query("algorithm == 'RVEA' and seed == 2 and evaluations == @n").iloc[0]
        assert row["points"] == len(front)
        if n == 150:
            assert row["hypervolume"] == pytest.approx(
                HV(ref_point=serial.space.reference_point)(serial.space(front))
            )


def test_processes_give_the_same_table(serial):
    parallel = compare(PROBLEM, ALGORITHMS, 150, seeds=3, grid=[50, 77], n_jobs=2)
    assert parallel.table.equals(serial.table)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:.*multi-threaded.*fork:DeprecationWarning")
def test_multiprocessing_gives_the_same_table(serial, tmp_path):
    with joblib.parallel_config("multiprocessing", n_jobs=2):
        forked = compare(PROBLEM, ALGORITHMS, 150, seeds=3, grid=[50, 77], folder=tmp_path)
        assert forked.table.equals(serial.table)
        again = compare(PROBLEM, ALGORITHMS, 150, seeds=4, grid=[50, 77], folder=tmp_path)
    assert again.runs["status"].tolist() == ["finished"] * 16
    assert len(list(tmp_path.iterdir())) == 16


@pytest.mark.filterwarnings("ignore:.*multi-threaded.*fork:DeprecationWarning")
def test_multiprocessing_keeps_runs_while_others_are_made(tmp_path):
    """Each call of run_all yields what is there before the last is."""
    tasks = {("NSGA-II", s): Task(PROBLEM, NSGA2(pop_size=12), 24, s) for s in range(5)}
    tasks["NSGA-II", 5] = Task(PROBLEM, FailingNSGA2(pop_size=12), 24, 6)
    with joblib.parallel_config("multiprocessing", n_jobs=2):
        results = run_all(tasks, None)
        first = [next(results), next(results)]
        assert [key for key, _ in first] == [("NSGA-II", 0), ("NSGA-II", 1)]
        rest = dict(results)
    assert len(rest) == 4
    assert rest["NSGA-II", 5].error == "ArithmeticError: seed 6 is even"


@pytest.mark.slow
def test_finished_runs_are_not_run_again(serial, tmp_path, monkeypatch):
    first = compare(PROBLEM, ALGORITHMS, 150, seeds=[1, 3], folder=tmp_path)
    assert len(list(tmp_path.iterdir())) == 8
    made = []
    monkeypatch.setattr(
        "mgeo.studies.dispatch.run", lambda task: made.append(task.seed) or record(task)
    )
    again = compare(PROBLEM, ALGORITHMS, 150, seeds=[1, 3], folder=tmp_path)
    assert made == []
    assert again.table.equals(first.table)
    # another label is the same run, another grid needs no new ones, and seed 2 is missing
    renamed = {name.lower(): algorithm for name, algorithm in ALGORITHMS.items()}
    longer = compare(PROBLEM, renamed, 150, seeds=3, grid=[50, 77], folder=tmp_path)
    assert made == [2] * 4
    values = longer.table.drop(columns="algorithm")
    assert values.equals(serial.table.drop(columns="algorithm"))
    # another budget, problem or parameter is another run
    for problem, sigma, n_eval in (
        (PROBLEM, 0.3, 140),
        (ZDT1(n_var=5), 0.3, 150),
        (PROBLEM, 0.2, 150),
    ):
        algorithm = MGEOReal(sigma=sigma, n_walkers=3, perturbation="range")
        compare(problem, {"MGEO": algorithm}, n_eval, seeds=1, folder=tmp_path)
    assert made == [2] * 4 + [1] * 3


def test_runs_of_another_function_are_not_taken(tmp_path):
    fronts = []
    for factor in (1.0, 1000.0):
        objectives = [lambda x, k=factor: k * x[0], lambda x: 1 - x[0] + x[1]]
        problem = FunctionalProblem(2, objectives, xl=0.0, xu=1.0)
        found = compare(problem, [NSGA2(pop_size=10)], 60, seeds=1, folder=tmp_path)
        fronts.append(next(iter(found.records.values())).front_F)
    assert len(list(tmp_path.iterdir())) == 2
    assert np.ptp(fronts[1][:, 0]) > 10 * np.ptp(fronts[0][:, 0])


class Connected(ZDT1):
    """Of what it computes by nobody can tell."""

    def __init__(self):
        super().__init__(n_var=3)
        self.service = SimpleNamespace(answers=(i for i in range(9)))


class Vouched(Connected):
    fingerprint = "service 3"


def test_runs_that_cannot_be_told_apart_are_made_and_not_kept(tmp_path, monkeypatch):
    made = []
    monkeypatch.setattr(
        "mgeo.studies.dispatch.run", lambda task: made.append(task.seed) or record(task)
    )
    algorithms = {"a": NSGA2(pop_size=10), "b": NSGA2(pop_size=12)}
    for _ in range(2):
        with pytest.warns(RuntimeWarning) as told:
            found = compare(Connected(), algorithms, 30, seeds=2, folder=tmp_path)
        (warning,) = told
        assert str(warning.message).startswith(
            "Connected.service cannot be looked into: cannot pickle 'generator' object: nobody "
            "knows whether a run of Connected is the one asked for"
        )
        assert "vouch by an attribute fingerprint of Connected" in str(warning.message)
        assert warning.filename == __file__
        assert len(found.records) == 4
    assert made == [1, 2] * 4
    assert list(tmp_path.iterdir()) == []
    for _ in range(2):
        compare(Vouched(), algorithms, 30, seeds=2, folder=tmp_path)
    assert len(made) == 12
    # where it is the algorithm, the other one's runs are kept
    algorithms["a"].owner = weakref.ref(Connected)
    with pytest.warns(RuntimeWarning, match=r"^NSGA2\.owner cannot be looked into: .*weakref"):
        compare(PROBLEM, algorithms, 30, seeds=2, folder=tmp_path / "more")
    assert len(list((tmp_path / "more").iterdir())) == 2


def test_runs_without_code_in_their_names_are_told_and_left(tmp_path):
    old = tmp_path / "NSGA2-0123456789abcdef0123-seed1.npz"
    old.write_bytes(b"old")
    with pytest.warns(RuntimeWarning, match=r"holds runs of an earlier mgeo \(1\).*are not used"):
        compare(PROBLEM, [NSGA2(pop_size=12)], 20, seeds=1, folder=tmp_path)
    assert old.read_bytes() == b"old"
    assert len(list(tmp_path.iterdir())) == 2


def test_runs_say_what_they_were_made_with(tmp_path, monkeypatch):
    first = compare(PROBLEM, [NSGA2(pop_size=12)], 20, seeds=1, folder=tmp_path)
    monkeypatch.setattr("mgeo.studies.fingerprint.modules.version", lambda name: "99.0")
    second = compare(PROBLEM, [NSGA2(pop_size=12)], 20, seeds=2, folder=tmp_path)
    here = first.records["NSGA2", 1].versions
    assert {"python", "mgeo", "numpy", "scipy", "pymoo"} <= here.keys()
    assert here["numpy"] == np.__version__
    assert dict(second.records["NSGA2", 1].versions) == dict(here)
    assert second.records["NSGA2", 2].versions["numpy"] == "99.0"
    told = second.runs["versions"].tolist()
    assert f"numpy {np.__version__}, " in told[0]
    assert "numpy 99.0, " in told[1]
    both = distinct(record.versions for record in second.records.values())
    assert both["numpy"] == sorted([np.__version__, "99.0"])
    assert both["python"] == platform.python_version()


KILLED = """
import sys, time
from pymoo.problems.multi import ZDT1
from pymoo.algorithms.moo.nsga2 import NSGA2
from mgeo import compare

class Slow(ZDT1):
    def _evaluate(self, X, out, *args, **kwargs):
        time.sleep(0.05)
        super()._evaluate(X, out, *args, **kwargs)

if __name__ == "__main__":
    result = compare(Slow(n_var=4), [NSGA2(pop_size=10)], 60, seeds=6, folder=sys.argv[1])
    result.table.to_csv(sys.argv[2], index=False)
"""


@pytest.mark.campaign
@pytest.mark.slow
def test_a_killed_comparison_goes_on_where_it_was(tmp_path):
    script, folder = tmp_path / "script.py", tmp_path / "runs"
    script.write_text(KILLED)

    def command(out):
        return [sys.executable, str(script), str(folder), str(tmp_path / out)]

    process = subprocess.Popen(command("never"))
    deadline = time.monotonic() + 300
    while len(list(folder.glob("*.npz"))) < 2:
        assert process.poll() is None
        assert time.monotonic() < deadline
        time.sleep(0.01)
    process.send_signal(signal.SIGKILL)
    assert process.wait() == -signal.SIGKILL
    found = {path: path.stat().st_mtime_ns for path in folder.glob("*.npz")}
    assert 2 <= len(found) < 6
    subprocess.run(command("resumed"), check=True)
    assert len(list(folder.glob("*.npz"))) == 6
    assert {path: path.stat().st_mtime_ns for path in found} == found
    whole = compare(ZDT1(n_var=4), [NSGA2(pop_size=10)], 60, seeds=6)
    assert (tmp_path / "resumed").read_text() == whole.table.to_csv(index=False)


def test_a_damaged_file_is_named(tmp_path):
    compare(PROBLEM, [NSGA2(pop_size=12)], 20, seeds=1, folder=tmp_path)
    (path,) = tmp_path.iterdir()
    path.write_bytes(path.read_bytes()[:100])
    with pytest.raises(ValueError, match=rf"{path.name}: .*delete it"):
        compare(PROBLEM, [NSGA2(pop_size=12)], 20, seeds=1, folder=tmp_path)


def test_a_run_that_fails_is_reported_and_the_rest_completes(tmp_path, capsys):
    algorithms = {"good": NSGA2(pop_size=12), "bad": FailingNSGA2(pop_size=12)}
    result = compare(PROBLEM, algorithms, 40, seeds=4, folder=tmp_path, progress=True)
    failed = result.runs[result.runs["status"] == "failed"]
    assert failed[["algorithm", "seed"]].to_numpy().tolist() == [["bad", 2], ["bad", 4]]
    assert set(failed["error"]) == {
        "ArithmeticError: seed 2 is even",
        "ArithmeticError: seed 4 is even",
    }
    assert result.final().groupby("algorithm").size().to_dict() == {"bad": 2, "good": 4}
    assert len(list(tmp_path.iterdir())) == 6
    lines = capsys.readouterr().err.splitlines()
    assert lines[0] == "ZDT1: 8 runs, 0 of them found on disk"
    assert lines[-1] == "8/8  bad, seed 4: failed: ArithmeticError: seed 4 is even"
    assert sum("failed" in line for line in lines) == 2
    assert len(lines) < 9  # runs that finish within a second of a line have none of their own


@pytest.mark.slow
def test_a_run_that_kills_its_process_fails_alone(tmp_path):
    algorithms = {"bad": DyingNSGA2(pop_size=12), "good": NSGA2(pop_size=12)}
    result = compare(PROBLEM, algorithms, 40, seeds=6, folder=tmp_path, n_jobs=2)
    failed = result.runs[result.runs["status"] == "failed"]
    assert failed[["algorithm", "seed"]].to_numpy().tolist() == [["bad", 2]]
    assert failed["error"].tolist() == ["its process died: TerminatedWorkerError"]
    assert len(list(tmp_path.iterdir())) == 11
    good = compare(PROBLEM, {"good": NSGA2(pop_size=12)}, 40, seeds=6)
    assert [r.front_F.tolist() for (name, _), r in result.records.items() if name == "good"] == [
        r.front_F.tolist() for r in good.records.values()
    ]


def test_an_algorithm_that_failed_everywhere_is_told_by_name():
    algorithms = {"good": NSGA2(pop_size=12), "bad": FailingNSGA2()}
    message = "^bad on ZDT1: 2 of 2 runs failed, the first with ArithmeticError: seed 2 is even$"
    with pytest.warns(FailedRunsWarning, match=message) as told:
        compare(PROBLEM, algorithms, 40, seeds=[2, 4])
    assert [warning.filename for warning in told] == [__file__]


def test_if_every_run_fails_the_first_error_is_raised():
    with pytest.raises(NothingToCompareError, match=r"all 2 runs failed.*seed 2 is even"):
        compare(PROBLEM, [FailingNSGA2()], 40, seeds=[2, 4])


def test_an_algorithm_without_ideas_fails():
    with pytest.raises(RuntimeError, match="StuckSearch made no new candidate after 7 of 40"):
        record(Task(PROBLEM, StuckSearch(), 40, 1))


def test_global_random_state_is_seeded_and_put_back():
    np.random.seed(5)  # noqa: NPY002
    random.seed(5)
    expected = np.random.random(), random.random()  # noqa: NPY002
    np.random.seed(5)  # noqa: NPY002
    random.seed(5)
    runs = [record(Task(PROBLEM, GlobalRandomSearch(), 60, seed)) for seed in (1, 1, 2)]
    assert (np.random.random(), random.random()) == expected  # noqa: NPY002
    assert np.array_equal(runs[0].F, runs[1].F)
    assert not np.array_equal(runs[0].F, runs[2].F)


def test_infeasible_and_undefined_points_count_but_are_no_front():
    result = compare(Half(), [NSGA2(pop_size=10)], 100, seeds=2, grid=[1, 100])
    for run in result.records.values():
        assert run.failed > 0
        assert (run.X[:, 0] >= 0.5).all()
        assert not ((run.X[:, 0] > 0.6) & (run.X[:, 0] < 0.7)).any()
        assert np.isfinite(run.front_F).all()
    assert (result.runs["failed_evaluations"] == [r.failed for r in result.records.values()]).all()


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ((PROBLEM, [], 10), ValueError, "at least one"),
        ((PROBLEM, ["nsga2"], 10), TypeError, "expected a pymoo Algorithm"),
        ((PROBLEM, [NSGA2(), NSGA2()], 10), ValueError, "expected labels"),
        ((PROBLEM, [NSGA2()], 0), ValueError, "n_eval = 0"),
        ((PROBLEM, [NSGA2()], 10, 0), ValueError, "seeds = 0"),
        ((PROBLEM, [NSGA2()], 10, [1, 1]), ValueError, "different"),
        ((PROBLEM, [NSGA2()], 10, [-1]), ValueError, r"seeds\[0\] = -1"),
    ],
)
def test_bad_arguments_are_refused(arguments, error, message):
    with pytest.raises(error, match=message):
        compare(*arguments)


class Shifted(Sphere):
    """Least value -3, and infeasible where the first variable is small."""

    def __init__(self):
        super().__init__(n_var=3)
        self.n_ieq_constr = 1

    def _evaluate(self, X, out, *args, **kwargs):
        super()._evaluate(X, out, *args, **kwargs)
        out["F"], out["G"] = out["F"] - 3.0, 0.3 - X[:, :1]


@pytest.mark.slow
def test_of_one_objective_the_best_value_counts():
    algorithms = {
        "GEO": MGEOReal(sigma=0.1, n_walkers=3, perturbation="range"),
        "GA": GA(pop_size=12),
        "random": RandomSearch(n_points_per_iteration=12),
    }
    found = compare(Shifted(), algorithms, 240, seeds=4, grid=[1, 120])
    assert [i.name for i in found.indicators] == ["best_value"]
    for name, seed in found.records:
        values = []
        problem = Shifted()
        problem.callback = lambda X, out, into=values: into.extend(
            np.where(out["G"] <= 0, out["F"], np.inf)[:, 0]
        )
        minimize(problem, algorithms[name], ("n_eval", 240), seed=seed)
        rows = found.table[(found.table["algorithm"] == name) & (found.table["seed"] == seed)]
        assert rows["best_value"].tolist() == [min(values[:n]) for n in (1, 120, 240)]
        assert rows["points"].tolist() == np.isfinite(rows["best_value"]).astype(int).tolist()
    assert np.isinf(found.table["best_value"]).any()  # nothing feasible at first
    medians = found.summary()[("best_value", "median")]
    assert -3.0 < medians.min() < -2.8
    assert found.order()[0] == medians.idxmin()
    assert list(found.figures()) == ["anytime", "boxes"]
    assert found.figures()["anytime"].layout.yaxis.type == "linear"
    best = found.summary()[("best_value", "mean")].idxmin()
    assert f"\\textbf{{{found.overview().loc[best, 'best value'][:5]}" in found.to_latex()
    sentences = conclusions(found)
    assert len(sentences) == 2
    assert sentences[0].startswith(f"By best value, {found.order()[0]} ranks first: -2.9")
    assert len(found.tests().pairs) == 3


@pytest.mark.parametrize("option", [{"bounds": ([0.0], [1.0])}, {"reference_front": [[0.0]]}])
def test_one_objective_has_no_space_to_give(option):
    with pytest.raises(ValueError, match="expected none for a single objective"):
        compare(Sphere(), [GA(pop_size=12)], 24, seeds=1, **option)


def test_a_space_that_cannot_be_is_refused_before_any_run(tmp_path):
    with pytest.raises(ValueError, match="expected one or more ascending values"):
        compare(PROBLEM, [NSGA2()], 10, folder=tmp_path, parts=[2.0, 1.0])
    assert list(tmp_path.iterdir()) == []


def test_bad_grids_are_refused():
    with pytest.raises(ValueError, match="grid goes to 11: expected at most n_eval = 10"):
        compare(PROBLEM, [NSGA2()], 10, grid=[11])
    with pytest.raises(ValueError, match=r"grid\[0\] = 0"):
        compare(PROBLEM, [NSGA2()], 10, grid=[0])
    with pytest.raises(ValueError, match=r"grid = np\.int64"):
        compare(PROBLEM, [NSGA2()], 10, grid=np.int64(0))


def test_the_runs_folder_takes_no_part_files(tmp_path):
    compare(PROBLEM, [NSGA2(pop_size=12)], 20, seeds=2, folder=tmp_path / "a" / "b")
    assert all(name.endswith(".npz") for name in os.listdir(tmp_path / "a" / "b"))


@pytest.mark.slow
def test_runs_in_threads_share_their_problem():
    algorithms = {"MGEO": ALGORITHMS["MGEO"], "NSGA-II": ALGORITHMS["NSGA-II"]}
    problem = Element()
    before = dict(vars(problem))
    with joblib.parallel_config("threading", n_jobs=4):
        threads = compare(problem, algorithms, 200, seeds=6, progress=False)
    assert threads.runs["status"].tolist() == ["finished"] * 12
    assert problem.calls > 0
    assert {**vars(problem), "calls": 0} == before
    alone = compare(Element(), algorithms, 200, seeds=6, n_jobs=1, progress=False)
    assert threads.table.equals(alone.table)
